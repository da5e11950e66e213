// How much of a gradual slip accelerations do not show. docs/estimation.md, "Slip that is not
// seen".
#pragma once

#include "estimation/increments/imu_preintegration.h"
#include "gprodom/config.h"

namespace gprodom::slip {

class UnseenSlip {
 public:
  explicit UnseenSlip(const Config& config);

  // Variance of l that is left of `prior` (a variance) at a speed (m/s).
  double variance(double prior, double speed, const ImuNoise& noise) const;

 private:
  // m/s: change of speed that cannot be told from the IMU's noise while a slip grows.
  double unseen_speed(double speed, const ImuNoise& noise) const;

  double wheel_noise_, lag_s_;
};

}  // namespace gprodom::slip
