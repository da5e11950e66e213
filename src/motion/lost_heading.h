// Error of the position along the track by a heading that is not known to a small angle, as after
// seconds without a gyro.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "estimation/nav_state.h"

namespace gprodom {

// A heading that is off by d takes (1 - cos d) of the way that is driven since, and moves the robot
// aside by sin d of it. The estimator's covariance is linear in d and has the second part alone.
// With d normal and of variance s, and the whole way on one error d,
//   E (1 - cos d)^2 = 3/2 - 2 exp(-s/2) + exp(-2 s)/2,
// which is 3/4 s^2 where s is small.
class LostHeading {
 public:
  // The next state in effect, and the variance of its yaw, rad^2.
  void advance(const NavState& state, double yaw_variance);

  // Of the position, x and y in odom, m^2: what the estimator's lacks.
  Eigen::Matrix2d covariance() const { return off_m_ * off_m_.transpose(); }

 private:
  std::optional<Eigen::Vector2d> last_m_;
  Eigen::Vector2d off_m_ = Eigen::Vector2d::Zero();  // one standard deviation of all of it
};

}  // namespace gprodom
