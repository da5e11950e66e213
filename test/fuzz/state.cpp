// A saved state, a saved wheel, its slip, and a saved pair of wheels.
#include "persist/learnt.h"
#include "persist/saved_state.h"
#include "sealed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string title = title_of(to_bytes(gprodom::SavedState()));
  static const std::string wheel_title = title_of(to_bytes(gprodom::SavedWheel()));
  read_sealed(wheel_title, data, size,
              [](const std::string& bytes) { gprodom::saved_wheel_from("wheel", bytes); });
  static const std::string pair_title = title_of(to_bytes(gprodom::SavedPair()));
  read_sealed(pair_title, data, size,
              [](const std::string& bytes) { gprodom::saved_pair_from("pair", bytes); });
  static const std::string slip_title = title_of(to_bytes(gprodom::SavedSlip()));
  read_sealed(slip_title, data, size,
              [](const std::string& bytes) { gprodom::saved_slip_from("slip", bytes); });
  return read_sealed(title, data, size,
                     [](const std::string& bytes) { gprodom::saved_state_from("state", bytes); });
}
