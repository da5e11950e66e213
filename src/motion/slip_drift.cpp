#include "motion/slip_drift.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/by_time.h"

namespace gprodom {

namespace {

constexpr double kMoves_mps = 0.02;

// ns; a passage of two antennas lasts as long at most (Pipeline::keep_way).
constexpr TimeNs kRemembered = 60'000'000'000;

}  // namespace

SlipDrift::SlipDrift(const Config& config)
    : model_(slip_model(config.wheel)),
      enabled_(config.wheel.enabled && config.wheel.slip_share > 0),
      unseen_{config.wheel.noise, config.smoother.lag} {}

void SlipDrift::advance(const NavState& state, const ImuNoise& noise, double share,
                        std::optional<double> left) {
  if (!last_) joint_(2, 2) = enabled_ ? std::pow(model_.sigma(), 2) : 0.0;
  const NavState last = last_.value_or(state);
  last_ = state;
  remember(last.time);
  double variance = unseen(state, last, noise, share);
  sigma_ = std::sqrt(variance);
  if (variance <= 0) return;
  const double seconds = to_seconds(state.time - last.time);
  const Eigen::Vector2d moved = (state.p_odom - last.p_odom).head<2>();
  if (left) variance = std::min(variance, *left + model_.surface * model_.surface);

  const double kept = model_.correlation(seconds);
  joint_.row(2) *= kept;
  joint_.col(2) *= kept;
  joint_(2, 2) += variance * (1 - kept * kept);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F.topRightCorner<2, 1>() = moved;
  joint_ = (F * joint_ * F.transpose()).eval();
}

// Variance of l by accelerations alone.
double SlipDrift::unseen(const NavState& state, const NavState& last, const ImuNoise& noise,
                         double share) {
  moves_ = false;
  const double seconds = to_seconds(state.time - last.time);
  if (!enabled_ || seconds <= 0) return 0.0;
  const double speed = (state.p_odom - last.p_odom).head<2>().norm() / seconds;
  moves_ = speed > kMoves_mps;
  model_.share = share;
  return unseen_.variance(std::pow(model_.sigma(), 2), speed, noise);
}

void SlipDrift::remember(TimeNs time) {
  earlier_.push_back({time, joint_});
  while (earlier_.front().time < time - kRemembered) earlier_.pop_front();
}

void SlipDrift::measured(const NavState& state, const ImuNoise& noise, double share) {
  const NavState last = last_.value_or(state);
  remember(last.time);
  last_ = state;
  sigma_ = std::sqrt(unseen(state, last, noise, share));
  moves_ = false;
  joint_.row(2).setZero();
  joint_.col(2).setZero();
  joint_(2, 2) = enabled_ ? std::pow(model_.sigma(), 2) : 0.0;
}

void SlipDrift::measured_since(TimeNs time, double l_sigma) {
  const auto after = first_after(earlier_, time);
  if (after == earlier_.begin()) return;
  const Eigen::Matrix3d& then = std::prev(after)->joint;
  const Eigen::Vector3d with_l = then.col(2);
  const double variance = with_l[2] + l_sigma * l_sigma;
  const Eigen::Matrix3d before =
      variance > 0 ? Eigen::Matrix3d(then - with_l * with_l.transpose() / variance) : then;
  // A measured position may have made it smaller than it was then.
  if (before.topLeftCorner<2, 2>().trace() < covariance().trace())
    joint_.topLeftCorner<2, 2>() = before.topLeftCorner<2, 2>();
  joint_.topRightCorner<2, 1>().setZero();
  joint_.bottomLeftCorner<1, 2>().setZero();
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
