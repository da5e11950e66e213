// A saved state, a saved wheel, its slip, and a saved pair of wheels.
#include "persist/learnt.h"
#include "persist/saved_state.h"
#include "sealed.h"

namespace {

template <class Saved, class Read>
void read_as(const std::uint8_t* data, std::size_t size, Read read) {
  static const std::string title = title_of(to_bytes(Saved()));
  read_sealed(title, data, size, [&](const std::string& bytes) { read("saved", bytes); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read_as<gprodom::SavedWheel>(data, size, gprodom::saved_wheel_from);
  read_as<gprodom::SavedPair>(data, size, gprodom::saved_pair_from);
  read_as<gprodom::SavedSlip>(data, size, gprodom::saved_slip_from);
  read_as<gprodom::SavedState>(data, size, gprodom::saved_state_from);
  return 0;
}
