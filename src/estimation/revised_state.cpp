#include "estimation/revised_state.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <utility>

#include "estimation/kernels/so3.h"
#include "estimation/state_estimator.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Standard deviations, except for the time constant.
constexpr double kGyroBias = 1e-3;         // rad/s; of the new bias
constexpr double kAccelBias = 0.1;         // m/s^2; the accelerometer's bias may have moved as well
constexpr double kStandingSpeed = 0.05;    // m/s
constexpr double kTiltMemory_s = 2.0;      // s; time constant with which gravity corrects the tilt
constexpr double kExplainedByTilt = 0.05;  // rad; the wrong speed may have been explained by tilt
constexpr double kShift = 0.3;  // share of the correction: the track need not be straight

constexpr double kRounding = 1e-24;  // far below any variance

// All errors but those of heading and position.
constexpr std::array kOthers{0, 1, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

// How the error of the position follows from those: P_po P_oo^-1.
Eigen::Matrix<double, 3, 12> position_by_others(const StateMatrix& P) {
  // In standard deviations: the variances differ by many orders of magnitude.
  const Eigen::Matrix<double, 12, 1> variance = P.diagonal()(kOthers).cwiseMax(kRounding);
  const Eigen::Matrix<double, 12, 1> per_sigma = variance.cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, 12, 12> among =
      per_sigma.asDiagonal() * P(kOthers, kOthers) * per_sigma.asDiagonal();
  const Eigen::Matrix<double, 12, 3> with =
      per_sigma.asDiagonal() * P.middleCols<3>(row::kP)(kOthers, Eigen::all);
  return (per_sigma.asDiagonal() * among.ldlt().solve(with)).transpose();
}

}  // namespace

CarriedState with_gyro_bias(const CarriedState& from, const Vector3d& gyro_bias,
                            const NavState& known) {
  NavState x = from.state;
  const Vector3d change = x.R_odom_body() * (gyro_bias - x.gyro_bias);
  const double seconds = to_seconds(x.time - known.time);
  x.gyro_bias = gyro_bias;
  x.v_odom.setZero();

  StateMatrix P = plain_position(x, 1) * from.covariance * plain_position(x, 1).transpose();
  // The moment of the step is uniform over that time, so the mean square of the turn is a third.
  const double yaw = std::abs(change.z()) * seconds / std::sqrt(3.0);
  const double aside = yaw * (x.p_odom - known.p_odom).norm();
  P(row::kTheta + 2, row::kTheta + 2) += yaw * yaw;
  P.diagonal().segment<2>(row::kTheta).array() += std::pow(change.norm() * kTiltMemory_s, 2);
  P.diagonal().segment<2>(row::kP).array() += aside * aside;
  P = (plain_position(x, -1) * P * plain_position(x, -1).transpose()).eval();
  const Matrix3d I = Matrix3d::Identity();
  replace(P, row::kV, 3, kStandingSpeed * kStandingSpeed * I);
  replace(P, row::kBg, 3, kGyroBias * kGyroBias * I);
  replace(P, row::kBa, 3, kAccelBias * kAccelBias * I);
  return {x, 0.5 * (P + P.transpose())};
}

// The IMU's attitude in the world is known, apart from the heading: R' = Rz R R_new_old^T, with Rz
// such that the heading stays. An error theta, in odom, then becomes Rz theta; those of position
// and velocity do not change, beside what the chart makes of that of the attitude.
CarriedState with_turned_axes(const CarriedState& from, const Matrix3d& R_new_old) {
  NavState x = from.state;
  const Matrix3d R = x.R_odom_body(), turned = R * R_new_old.transpose();
  const double back = std::atan2(R(1, 0), R(0, 0)) - std::atan2(turned(1, 0), turned(0, 0));
  const Matrix3d Rz = Eigen::AngleAxisd(back, Vector3d::UnitZ()).toRotationMatrix();
  x.q_odom_body = Eigen::Quaterniond(Rz * turned).normalized();
  x.gyro_bias = R_new_old * x.gyro_bias;
  x.accel_bias = R_new_old * x.accel_bias;

  StateMatrix J = StateMatrix::Identity();
  J.block<3, 3>(row::kTheta, row::kTheta) = Rz;
  J.block<3, 3>(row::kP, row::kTheta) = so3::skew(x.p_odom) * (Rz - Matrix3d::Identity());
  J.block<3, 3>(row::kV, row::kTheta) = so3::skew(x.v_odom) * (Rz - Matrix3d::Identity());
  J.block<3, 3>(row::kBg, row::kBg) = J.block<3, 3>(row::kBa, row::kBa) = R_new_old;
  return {x, J * from.covariance * J.transpose()};
}

// The mean over hypotheses, each of which is a Kalman update with a gain of its own.
CarriedState with_counted_way(const CarriedState& from, const EstimatedWay& way, double counted_m,
                              const CountWeight& weight) {
  const double off = counted_m - way.reported_m;
  const StateVector& w = way.with_newest;
  return {retract(from.state, weight.mean * off * w),
          from.covariance + (std::pow(weight.sigma * off, 2) - weight.mean) * w * w.transpose()};
}

CarriedState with_speed_correction(const CarriedState& from, const SpeedCorrection& correction) {
  NavState x = from.state;
  const Matrix3d R = x.R_odom_body();
  StateMatrix P = plain_position(x, 1) * from.covariance * plain_position(x, 1).transpose();
  const Vector3d along = R.col(0) * (kShift * correction.ahead_m);
  P.block<3, 3>(row::kP, row::kP) += along * along.transpose();
  x.p_odom += correction.ahead_m * R.col(0);
  x.v_odom = correction.speed * R.col(0);
  P.diagonal().segment<2>(row::kTheta).array() += kExplainedByTilt * kExplainedByTilt;
  P = (plain_position(x, -1) * P * plain_position(x, -1).transpose()).eval();
  const Vector3d velocity(correction.sigma, kSideways, kSideways);
  replace(P, row::kV, 3, R * velocity.cwiseAbs2().asDiagonal() * R.transpose());
  return {x, 0.5 * (P + P.transpose())};
}

// The window begins anew where what it holds cannot go on.

// The window cannot be solved: restarts from the prediction, with a larger covariance.
void StateEstimator::discard_window(const NavState& state) {
  StateVector growth;
  growth << Vector3d::Constant(0.01), Vector3d::Constant(0.1), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-4), Vector3d::Constant(1e-2), scale_.is_held() ? 0.0 : 1e-3;
  last_covariance_ += StateMatrix(growth.cwiseAbs2().asDiagonal());
  restart(state);
}

// After a long gap of the IMU the errors of attitude and speed are too large for a linear solution.
void StateEstimator::carry_over(const StateInput& input) {
  const NavState& before = smoother_.state(smoother_.newest_id() - 1);
  const CarriedState carried = carry_on(config_, {before, last_covariance_}, input, gap_s_);
  if (batch_)
    batch_->set_state(static_cast<size_t>(smoother_.newest_id() + id_offset_), carried.state);
  continue_from(carried);
}

void StateEstimator::continue_from(const CarriedState& state) {
  last_covariance_ = state.covariance;
  restart(state.state);
}

// Starts a window of one state with last_covariance_. The part of the position's error that follows
// from the others stays in the window, since it is corrected when these are known. The rest, and
// the error of the heading, are common to all later states, and nothing observes them. They are
// kept apart in common_: with a large variance of the heading, nonlinear terms would count as
// information.
void StateEstimator::restart(const NavState& state) {
  constexpr int kYaw = row::kTheta + 2;  // and the three of position beside it
  static_assert(row::kP == kYaw + 1);
  const StateMatrix to_plain = plain_position(state, 1), to_chart = plain_position(state, -1);
  StateMatrix known = to_plain * last_covariance_ * to_plain.transpose();
  const Eigen::Matrix<double, 3, 12> follows = position_by_others(known);
  const Eigen::Matrix<double, 3, 4> shared =
      follows * known.middleCols<4>(kYaw)(kOthers, Eigen::all);
  const Matrix3d of_position = 0.5 * (shared.rightCols<3>() + shared.rightCols<3>().transpose());
  common_.setZero();
  common_.block<4, 4>(kYaw, kYaw) = known.block<4, 4>(kYaw, kYaw);
  common_.block<3, 3>(row::kP, row::kP) -= of_position;
  common_.block<3, 1>(row::kP, kYaw) -= shared.col(0);
  common_.block<1, 3>(kYaw, row::kP) -= shared.col(0).transpose();
  known.row(kYaw).setZero();
  known.col(kYaw).setZero();
  known(kYaw, kYaw) = kOriginYawSigma * kOriginYawSigma;
  known.block<3, 3>(row::kP, row::kP) = of_position;
  known.diagonal().segment<3>(row::kP).array() += kOriginPositionSigma * kOriginPositionSigma;
  known = (to_chart * known * to_chart.transpose()).eval();
  common_ = (to_chart * common_ * to_chart.transpose()).eval();
  settled_.reset();
  id_offset_ += smoother_.newest_id();
  smoother_ = FixedLagSmoother(config_.smoother.lag, {}, config_.smoother.solver, state,
                               gaussian_prior(state, known));
  motion_.clear();
}

}  // namespace gprodom
