// Does the IMU's vibration tell whether the robot stands?
//
// A robot with electric motors is quiet at rest. A car whose engine runs vibrates at rest about as
// much as it does while it drives, and by a different amount from second to second. So the level at
// rest is compared with the levels of the last two minutes of driving.
#pragma once

#include <deque>
#include <optional>

#include "estimation/increments/imu_preintegration.h"

namespace gprodom {

class Vibration {
 public:
  // Densities over an interval in which the wheel turned.
  void drives(const ImuNoise& measured);

  // Does it vibrate much less than it usually does while it drives?
  bool far_below_driving(const ImuNoise& measured) const;

  // May a robot that vibrates like this stand, although it does not vibrate as it did at rest?
  // at_rest: densities of an earlier standstill, if there was one.
  bool hides_rest(const ImuNoise& measured, const std::optional<ImuNoise>& at_rest) const;

 private:
  double driving(double ImuNoise::*sensor, double share) const;

  std::deque<ImuNoise> driving_;  // newest last
};

}  // namespace gprodom
