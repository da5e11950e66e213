#include "motion/slip_drift.h"

#include <algorithm>
#include <cmath>

#include "motion/grip_filter.h"

namespace gprodom {

namespace {

constexpr double kMoves_mps = 0.02;

}  // namespace

SlipDrift::SlipDrift(const Config& config)
    : model_(slip_model(config.wheel)),
      enabled_(config.wheel.enabled && config.wheel.slip_share > 0) {}

void SlipDrift::advance(const NavState& state, double unseen) {
  if (!last_) joint_(2, 2) = enabled_ ? GripFilter::prior_slip_variance() : 0.0;
  const NavState last = last_.value_or(state);
  last_ = state;
  sigma_ = 0.0;
  moves_ = false;
  const double seconds = to_seconds(state.time - last.time);
  if (!enabled_ || seconds <= 0) return;
  const Eigen::Vector2d moved = (state.p_odom - last.p_odom).head<2>();
  const double speed = moved.norm() / seconds;
  moves_ = speed > kMoves_mps;
  sigma_ = model_.sigma() * std::sqrt(std::min(1.0, unseen));
  const double variance = GripFilter::prior_slip_variance() * unseen;

  const double kept = model_.correlation(seconds);
  joint_.row(2) *= kept;
  joint_.col(2) *= kept;
  joint_(2, 2) += variance * (1 - kept * kept);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F.topRightCorner<2, 1>() = moved;
  joint_ = (F * joint_ * F.transpose()).eval();
}

// P - P H^T (H P H^T + M^-1)^-1 H P with H = [I 0], for an information M that may be singular.
void SlipDrift::measure(const Eigen::Matrix2d& information) {
  const Eigen::Matrix<double, 3, 2> PHt = joint_.leftCols<2>();
  const Eigen::Matrix2d scaled =
      (Eigen::Matrix2d::Identity() + information * PHt.topRows<2>()).inverse() * information;
  const Eigen::Matrix3d left = joint_ - PHt * scaled * PHt.transpose();
  joint_ = 0.5 * (left + left.transpose());
}

}  // namespace gprodom
