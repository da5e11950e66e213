#include "estimation/predict.h"

#include "estimation/kernels/block_products.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using so3::skew;

namespace {

NavState moved(const NavState& x, double dt, const ImuPreintegration::Delta& delta,
               double gravity_mps2) {
  const Vector3d g(0, 0, -gravity_mps2);
  NavState y = x;
  y.time = x.time + from_seconds(dt);
  y.q_odom_body = (x.q_odom_body * delta.q).normalized();
  y.p_odom = x.p_odom + x.v_odom * dt + 0.5 * g * dt * dt + x.q_odom_body * delta.p;
  y.v_odom = x.v_odom + g * dt + x.q_odom_body * delta.v;
  return y;
}

// y: the propagated state.
PropagationJacobian jacobian(const NavState& x, const NavState& y, const ImuPreintegration& since,
                             const ImuPreintegration::Delta& delta) {
  const double dt = since.duration();
  const Matrix3d R = x.R_odom_body(), I = Matrix3d::Identity();
  const Vector3d turned = since.dq_dbg() * (x.gyro_bias - since.gyro_bias());
  // In the chart, theta also rotates position and velocity.
  PropagationJacobian F = PropagationJacobian::Zero();
  F.block<3, 3>(0, row::kTheta) = I;
  F.block<3, 3>(0, row::kBg) = y.R_odom_body() * so3::right_jacobian(turned) * since.dq_dbg();
  F.block<3, 3>(3, row::kTheta) = -skew(x.p_odom + x.v_odom * dt + R * delta.p);
  F.block<3, 3>(3, row::kP) = I;
  F.block<3, 3>(3, row::kV) = dt * I;
  F.block<3, 3>(3, row::kBg) = R * since.dp_dbg();
  F.block<3, 3>(3, row::kBa) = R * since.dp_dba();
  F.block<3, 3>(6, row::kTheta) = -skew(x.v_odom + R * delta.v);
  F.block<3, 3>(6, row::kV) = I;
  F.block<3, 3>(6, row::kBg) = R * since.dv_dbg();
  F.block<3, 3>(6, row::kBa) = R * since.dv_dba();
  return F;
}

}  // namespace

NavState propagate(const NavState& x, const ImuPreintegration& since, double gravity_mps2) {
  return moved(x, since.duration(), since.delta(x.gyro_bias, x.accel_bias), gravity_mps2);
}

PropagationJacobian propagation_jacobian(const NavState& x, const ImuPreintegration& since,
                                         double gravity_mps2) {
  const auto delta = since.delta(x.gyro_bias, x.accel_bias);
  return jacobian(x, moved(x, since.duration(), delta, gravity_mps2), since, delta);
}

OdometryEstimate predict(const NavState& x, const StateMatrix& covariance,
                         const ImuPreintegration& since, double gravity_mps2) {
  const auto delta = since.delta(x.gyro_bias, x.accel_bias);
  const NavState y = moved(x, since.duration(), delta, gravity_mps2);
  const Matrix3d R = x.R_odom_body(), Ry = y.R_odom_body();
  Matrix9d P = propagated_covariance(jacobian(x, y, since, delta), covariance);
  // Preintegrated noise: rotation (at y), velocity, position (at x).
  const Matrix3d* const turn[] = {&Ry, &R, &R};
  constexpr int from[] = {0, 6, 3};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      P.block<3, 3>(3 * i, 3 * j) +=
          *turn[i] * since.covariance().block<3, 3>(from[i], from[j]) * turn[j]->transpose();
  P = 0.5 * (P + P.transpose()).eval();

  OdometryEstimate out;
  out.time = y.time;
  out.p_odom_body = y.p_odom;
  out.q_odom_body = y.q_odom_body;
  out.v_body = Ry.transpose() * y.v_odom;
  out.pose_covariance << P.block<3, 3>(3, 3), P.block<3, 3>(3, 0), P.block<3, 3>(0, 3),
      P.block<3, 3>(0, 0);
  Eigen::Matrix<double, 3, 9> V = Eigen::Matrix<double, 3, 9>::Zero();  // R^T v under the errors
  V.leftCols<3>() = Ry.transpose() * skew(y.v_odom);
  V.rightCols<3>() = Ry.transpose();
  out.velocity_covariance = V * P * V.transpose();
  out.gyro_bias = y.gyro_bias;
  out.accel_bias = y.accel_bias;
  out.wheel_scale = y.wheel_scale;
  out.wheel_scale_sigma = std::sqrt(covariance(row::kScale, row::kScale));
  return out;
}

}  // namespace gprodom
