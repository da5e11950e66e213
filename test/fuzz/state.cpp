// A saved state.
#include "persist/saved_state.h"
#include "sealed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string title = title_of(to_bytes(gprodom::SavedState()));
  return read_sealed(title, data, size,
                     [](const std::string& bytes) { gprodom::saved_state_from("state", bytes); });
}
