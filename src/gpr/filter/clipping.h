// Samples at the digitiser's rails, whose true value is unknown.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace gprodom::gpr {

// Learns the rails: the largest and the smallest value of the stream, once each has come several
// times. Values that are not clipped do not repeat exactly.
class ClippingDetector {
 public:
  // Sets entries of `used` (one per sample, 1: good) to 0 for the samples at a rail and `margin`
  // samples on either side, which interpolation and derivatives would spoil. Other entries stay.
  void mark(const std::vector<float>& samples, int margin, float* used);
  void reset() { *this = ClippingDetector(); }

 private:
  static constexpr int kRepeats = 3;
  struct Rail {
    float value = 0.0f;
    int hits = 0;
  };
  static void learn(Rail& rail, float value, bool beyond);

  Rail top_{std::numeric_limits<float>::lowest(), 0};
  Rail bottom_{std::numeric_limits<float>::max(), 0};
};

}  // namespace gprodom::gpr
