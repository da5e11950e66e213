#include "motion/slip/unseen_slip.h"

#include <algorithm>
#include <cmath>

#include "estimation/nav_state.h"

namespace gprodom::slip {

// The speed follows the wheel with the time constant of a Kalman filter of both noises (wheel and
// IMU). If a slip grows over the window's length, only the part within that time shows.
double UnseenSlip::variance(double prior, double speed, const ImuNoise& noise) const {
  double seen = 0.0;
  if (speed > 0) {
    const double carried_s = std::min(lag_s, wheel_noise * std::sqrt(speed) / noise.accel_density);
    const double tilt_rate = kStandardGravity * noise.gyro_density;
    const double variance = noise.accel_density * noise.accel_density * carried_s +
                            tilt_rate * tilt_rate * std::pow(carried_s, 3) / 3;
    const double unseen_mps = std::sqrt(variance) * lag_s / carried_s;
    seen = speed / unseen_mps;
  }
  return 1 / (1 / prior + seen * seen);
}

}  // namespace gprodom::slip
