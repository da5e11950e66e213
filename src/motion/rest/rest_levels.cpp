#include "motion/rest/rest_levels.h"

#include <algorithm>

#include "motion/rest/imu_noise.h"

namespace gprodom {

namespace {

// Of both, what is more.
ImuNoise larger(const ImuNoise& a, const ImuNoise& b) {
  return {std::max(a.gyro_density, b.gyro_density), std::max(a.accel_density, b.accel_density)};
}

}  // namespace

void RestLevels::measure(const std::vector<ImuSample>& samples, double wheel_mps) {
  vibration_ = measured_noise(samples);
  wheel_mps_ = wheel_mps;
}

void RestLevels::begin(const InitialState& initial) {
  noise_ = initial.noise;
  vibration_ = larger(vibration_, noise_);
  known_ = !initial.on_the_move;
  if (initial.on_the_move) own_ = initial.noise;
}

void RestLevels::stood(const std::vector<ImuSample>& samples, double wheel_mps) {
  if (!own_) return;
  const ImuNoise now = larger(measured_noise(samples), *own_);
  // By more than chance: the least of many measurements of one noise is below that noise.
  constexpr double kClearly = 1.2;
  if (known_ && kClearly * now.accel_density > noise_.accel_density) return;
  noise_ = vibration_ = now;
  wheel_mps_ = wheel_mps;
  known_ = true;
}

}  // namespace gprodom
