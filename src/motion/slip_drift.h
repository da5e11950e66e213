// Error of the odometry by slip that no sensor shows. A wheel that slips gradually is not detected,
// and the estimator's own covariance contains only the wheel's noise, so it is too small then.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "estimation/graph/slip_model.h"
#include "estimation/increments/imu_preintegration.h"
#include "estimation/nav_state.h"
#include "gprodom/config.h"
#include "motion/slip/unseen_slip.h"

namespace gprodom {

// The slip l = ln(true / reported distance) is a Gauss-Markov process. Its variance is that of the
// prior, reduced by what accelerations would have shown (docs/estimation.md, "Slip that is not
// seen"):
//   1 / var(l) = 1 / sigma_l^2 + v^2 / sigma_v^2,
// with sigma_v (m/s) the change of speed that the estimator cannot tell from the IMU's noise while
// a slip grows. The position's covariance follows along the path from dp = (p_b - p_a) l.
class SlipDrift {
 public:
  explicit SlipDrift(const Config& config);

  // The next state in effect. noise: of the IMU since the last one. share: of the path on which the
  // wheel slips, as learnt. left: variance of l that the online slip estimation leaves, if it
  // knows; the covariance has it where it is less than what accelerations leave.
  void advance(const NavState& state, const ImuNoise& noise, double share,
               std::optional<double> left = std::nullopt);

  // The next state, where the distance is measured whatever the wheel does.
  void measured(const NavState& state, const ImuNoise& noise, double share);

  // The distance since that time has been measured after all, and with it the slip, with the
  // standard deviation l_sigma. What slip had added to the position's covariance since then is
  // taken back, and slip of shortly before is known better.
  void measured_since(TimeNs time, double l_sigma);

  // Information (1/m^2) of a measurement of the position (x, y in odom) at the last state. It
  // reduces the variance of past slip as well.
  void measure(const Eigen::Matrix2d& information);

  // Standard deviation of l over the last interval by accelerations alone; 0 without a wheel, or if
  // it did not turn. The pose graph weighs steps by it.
  double sigma() const { return sigma_; }
  // The robot moves, and accelerations would show less than half of the prior's variance of l.
  bool unwitnessed() const {
    return moves_ && sigma_ * sigma_ > 0.5 * model_.sigma() * model_.sigma();
  }
  // Of the position, x and y in odom, m^2.
  Eigen::Matrix2d covariance() const { return joint_.topLeftCorner<2, 2>(); }

 private:
  void remember(TimeNs time);
  double unseen(const NavState& state, const NavState& last, const ImuNoise& noise, double share);

  SlipModel model_;
  bool enabled_;
  slip::UnseenSlip unseen_;
  std::optional<NavState> last_;
  Eigen::Matrix3d joint_ = Eigen::Matrix3d::Zero();  // of x, y, l
  double sigma_ = 0.0;
  bool moves_ = false;
  struct Earlier {
    TimeNs time;
    Eigen::Matrix3d joint;
  };
  std::deque<Earlier> earlier_;  // of the last states
};

}  // namespace gprodom
