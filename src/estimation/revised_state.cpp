#include "estimation/revised_state.h"

#include <cmath>

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Standard deviations, except for the time constant.
constexpr double kGyroBias = 1e-3;       // rad/s; of the new bias
constexpr double kAccelBias = 0.1;       // m/s^2; the accelerometer's bias may have moved as well
constexpr double kStandingSpeed = 0.05;  // m/s
constexpr double kTiltMemory_s = 2.0;    // s; time constant with which gravity corrects the tilt

constexpr double kSideways = 0.05;  // m/s
constexpr double kTilt = 0.05;      // rad; the wrong speed may have been explained by tilt
constexpr double kShift = 0.3;      // share of the correction: the track need not be straight

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

CarriedState with_speed_correction(const CarriedState& from, const SpeedCorrection& correction) {
  NavState x = from.state;
  const Matrix3d R = x.R_odom_body();
  StateMatrix P = plain_position(x, 1) * from.covariance * plain_position(x, 1).transpose();
  const Vector3d along = R.col(0) * (kShift * correction.ahead_m);
  P.block<3, 3>(row::kP, row::kP) += along * along.transpose();
  x.p_odom += correction.ahead_m * R.col(0);
  x.v_odom = correction.speed * R.col(0);
  P.diagonal().segment<2>(row::kTheta).array() += kTilt * kTilt;
  P = (plain_position(x, -1) * P * plain_position(x, -1).transpose()).eval();
  const Vector3d velocity(correction.sigma, kSideways, kSideways);
  replace(P, row::kV, 3, R * velocity.cwiseAbs2().asDiagonal() * R.transpose());
  return {x, 0.5 * (P + P.transpose())};
}

}  // namespace gprodom
