// A saved state.
#include "pipeline/saved_state.h"
#include "sealed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return read_sealed("gprodom state 1", data, size,
                     [](const std::string& bytes) { gprodom::saved_state_from("state", bytes); });
}
