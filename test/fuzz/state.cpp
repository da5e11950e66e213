// A saved state, and a saved wheel.
#include "persist/saved_state.h"
#include "persist/saved_wheel.h"
#include "sealed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string title = title_of(to_bytes(gprodom::SavedState()));
  static const std::string wheel_title = title_of(to_bytes(gprodom::SavedWheel()));
  read_sealed(wheel_title, data, size,
              [](const std::string& bytes) { gprodom::saved_wheel_from("wheel", bytes); });
  return read_sealed(title, data, size,
                     [](const std::string& bytes) { gprodom::saved_state_from("state", bytes); });
}
