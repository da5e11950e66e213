#include "motion/slip/unseen_slip.h"

#include <algorithm>
#include <cmath>

#include "estimation/nav_state.h"

namespace gprodom::slip {

UnseenSlip::UnseenSlip(const Config& config)
    : wheel_noise_(config.wheel.noise), lag_s_(config.smoother.lag) {}

double UnseenSlip::variance(double prior, double speed, const ImuNoise& noise) const {
  const double seen = speed > 0 ? speed / unseen_speed(speed, noise) : 0.0;
  return 1 / (1 / prior + seen * seen);
}

// The speed follows the wheel with the time constant of a Kalman filter of both noises (wheel and
// IMU). If a slip grows over the window's length, only the part within that time shows.
double UnseenSlip::unseen_speed(double speed, const ImuNoise& noise) const {
  const double carried_s = std::min(lag_s_, wheel_noise_ * std::sqrt(speed) / noise.accel_density);
  const double tilt_rate = kStandardGravity * noise.gyro_density;
  const double variance = noise.accel_density * noise.accel_density * carried_s +
                          tilt_rate * tilt_rate * std::pow(carried_s, 3) / 3;
  return std::sqrt(variance) * lag_s_ / carried_s;
}

}  // namespace gprodom::slip
