// How much of a gradual slip accelerations do not show. docs/estimation.md, "Slip that is not
// seen".
#pragma once

#include "estimation/increments/imu_preintegration.h"

namespace gprodom::slip {

struct UnseenSlip {
  double wheel_noise, lag_s;  // m/sqrt(m); length of the window

  // Variance of l that is left of `prior` (a variance) at a speed (m/s).
  double variance(double prior, double speed, const ImuNoise& noise) const;
};

}  // namespace gprodom::slip
