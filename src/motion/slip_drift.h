// What odometry may be off by slip that no witness sees. A wheel that slips gradually is believed:
// the estimator's own covariance, which knows the wheel's noise alone, does not hold then.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "estimation/graph/slip_model.h"
#include "estimation/imu_preintegration.h"
#include "estimation/nav_state.h"
#include "gprodom/config.h"

namespace gprodom {

// The slip l = ln(true / reported distance) as a Gauss-Markov process of the variance that the
// prior has, less what accelerations would have shown (docs/estimation.md, "Slip that is not
// seen"):
//   1 / var(l) = 1 / sigma_l^2 + v^2 / sigma_v^2,  sigma_v (m/s) the change of speed that the
// estimator does not tell from the IMU's noise while a slip comes on. The position's covariance
// follows from it along the path, as dp = (p_b - p_a) l.
class SlipDrift {
 public:
  explicit SlipDrift(const Config& config);

  // A state in effect, later than the last. noise: of the IMU, since then.
  void advance(const NavState& state, const ImuNoise& noise);

  // What was measured of the place (x, y in odom) at the last state: its information, 1/m^2. It
  // tells of past slip as well.
  void measure(const Eigen::Matrix2d& information);

  // Of l over the last interval; 0 where there is no wheel or it did not turn.
  double sigma() const { return sigma_; }
  // Of the position, x and y in odom, m^2.
  Eigen::Matrix2d covariance() const { return joint_.topLeftCorner<2, 2>(); }

 private:
  double unseen_speed(double speed, const ImuNoise& noise) const;

  SlipModel model_;
  bool enabled_;
  double wheel_noise_, lag_s_, gravity_;
  std::optional<NavState> last_;
  Eigen::Matrix3d joint_ = Eigen::Matrix3d::Zero();  // of x, y, l
  double sigma_ = 0.0;
};

}  // namespace gprodom
