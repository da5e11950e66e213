#include "estimation/long_gap.h"

#include <algorithm>
#include <cmath>

#include "estimation/increments/wheel_increment.h"
#include "estimation/kernels/so3.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Standard deviations.
constexpr double kMostTilt = 0.03;     // rad; change of roll and pitch in the gap, at most
constexpr double kTilting = 0.02;      // rad/sqrt(s); its growth up to kMostTilt
constexpr double kUnknownYaw = 1.8;    // rad; of an unknown heading
constexpr double kSpeedChange = 0.2;   // m/s; of the speed against the wheel's mean speed
constexpr double kUnknownSpeed = 1.0;  // m/s

}  // namespace

void replace(StateMatrix& covariance, int first, int size, const Eigen::MatrixXd& block) {
  covariance.middleRows(first, size).setZero();
  covariance.middleCols(first, size).setZero();
  covariance.block(first, first, size, size) = block;
}

StateMatrix plain_position(const NavState& x, double sign) {
  StateMatrix m = StateMatrix::Identity();
  m.block<3, 3>(row::kP, row::kTheta) = -sign * so3::skew(x.p_odom);
  return m;
}

CarriedState carry_on(const Config& config, const CarriedState& from, const StateInput& input,
                      double gap_s) {
  const NavState& x = from.state;
  const bool wheel = input.has_wheel && !input.wheel_contradicted;
  const double speed = (x.q_odom_body.conjugate() * x.v_odom).x();
  WheelIncrement motion;
  NavState y = x;
  double dt = 0.0;
  for (const MotionStep& step : input.steps) {
    Vector3d rate = Vector3d::Zero();
    if (!step.long_gap || step.gap_turn) rate = angular_velocity(step, x.gyro_bias) - x.gyro_bias;
    motion.integrate(rate, step.dt, wheel ? step.wheel_m / x.wheel_scale : speed * step.dt);
    y.q_odom_body = (y.q_odom_body * so3::exp(rate * step.dt)).normalized();
    dt += step.dt;
  }
  y.time = input.time;
  y.p_odom += x.q_odom_body * motion.displacement();
  const Matrix3d R = y.R_odom_body();
  y.v_odom = R.col(0) * (motion.distance() / dt);

  const double longer = (2 * gap_s - dt) * dt;  // growth of the gap's square in this interval
  const WheelConfig& w = config.wheel;
  const double forward = wheel ? w.noise * w.noise * motion.path() + w.noise_floor * w.noise_floor
                               : kUnknownSpeed * kUnknownSpeed * longer;
  const double sideways = kSideways * kSideways * longer;
  // A known motion does not change the errors in the chart. The errors of the motion itself are
  // added as plain errors.
  StateMatrix P = plain_position(y, 1) * from.covariance * plain_position(y, 1).transpose();
  double& yaw = P(row::kTheta + 2, row::kTheta + 2);
  yaw = std::max(yaw, std::min(yaw + input.turn_variance, kUnknownYaw * kUnknownYaw));
  for (int axis : {row::kTheta, row::kTheta + 1}) {
    double& tilt = P(axis, axis);
    tilt = std::max(tilt, std::min(tilt + kTilting * kTilting * dt, kMostTilt * kMostTilt));
  }
  P.block<3, 3>(row::kP, row::kP) +=
      R * Vector3d(forward, sideways, sideways).asDiagonal() * R.transpose();
  P.diagonal().segment<3>(row::kBg).array() += std::pow(config.imu.gyro_bias_walk, 2) * dt;
  P.diagonal().segment<3>(row::kBa).array() += std::pow(config.imu.accel_bias_walk, 2) * dt;
  const double scale_walk = w.scale_sigma > 0 ? kWheelScaleWalk : 0.0;
  P(row::kScale, row::kScale) += scale_walk * scale_walk * dt;
  P = (plain_position(y, -1) * P * plain_position(y, -1).transpose()).eval();
  // The velocity is known in body axes, whatever the heading. So in the chart it is independent of
  // the heading's error.
  const Vector3d velocity(wheel ? kSpeedChange : kUnknownSpeed, kSideways, kSideways);
  replace(P, row::kV, 3, R * velocity.cwiseAbs2().asDiagonal() * R.transpose());
  return {y, 0.5 * (P + P.transpose())};
}

}  // namespace gprodom
