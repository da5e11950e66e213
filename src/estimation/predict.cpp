#include "estimation/predict.h"

#include <algorithm>
#include <cmath>

#include "estimation/kernels/block_products.h"
#include "estimation/kernels/so3.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using so3::skew;

namespace {

using Matrix93d = Eigen::Matrix<double, 9, 3>;

NavState moved_by(const NavState& x, double dt, const ImuPreintegration::Delta& delta,
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

// The rows of position and velocity, for the movement since the state: without what moves or turns
// the state itself.
PropagationJacobian movement_since(const NavState& x, const PropagationJacobian& F) {
  PropagationJacobian moves = F;
  moves.topRows<3>().setZero();
  moves.block<3, 3>(3, row::kP).setZero();
  moves.block<3, 3>(3, row::kTheta) += skew(x.p_odom);
  moves.col(row::kTheta + 2).setZero();  // yaw
  return moves;
}

}  // namespace

NavState propagate(const NavState& x, const ImuPreintegration& since, double gravity_mps2) {
  return moved_by(x, since.duration(), since.delta(x.gyro_bias, x.accel_bias), gravity_mps2);
}

PropagationJacobian propagation_jacobian(const NavState& x, const ImuPreintegration& since,
                                         double gravity_mps2) {
  const auto delta = since.delta(x.gyro_bias, x.accel_bias);
  return jacobian(x, moved_by(x, since.duration(), delta, gravity_mps2), since, delta);
}

OdometryEstimate predict(const NavState& x, const StateMatrix& covariance,
                         const ImuPreintegration& since, double gravity_mps2) {
  const auto delta = since.delta(x.gyro_bias, x.accel_bias);
  const NavState y = moved_by(x, since.duration(), delta, gravity_mps2);
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

PredictedWay way_further(const PredictedWay& before, const NavState& x,
                         const ImuPreintegration& since, const Vector3d& contact,
                         double gravity_mps2) {
  const NavState y = propagate(x, since, gravity_mps2);
  const Matrix3d R = x.R_odom_body(), Ry = y.R_odom_body();
  PredictedWay way = way_begins(y);
  way.moved_m =
      before.moved_m + 0.5 * (before.R_odom_body + Ry).transpose() *
                           (y.p_odom - before.p_odom + (Ry - before.R_odom_body) * contact);
  // For what errors change, the axes at half the turn stand for those on the way. Along the track
  // the arc is longer than its chord.
  way.turned_rad = std::acos(std::clamp(R.col(0).dot(Ry.col(0)), -1.0, 1.0));
  const double half = 0.5 * way.turned_rad;
  const Vector3d ahead = (R.col(0) + Ry.col(0)).normalized();
  const Vector3d left = (R.col(2) + Ry.col(2)).cross(ahead).normalized();
  Matrix3d axes;  // in odom
  axes << (half > 1e-4 ? half / std::sin(half) : 1.0) * ahead, left, ahead.cross(left);
  // An error of the attitude turns the way and its axes alike, but not gravity.
  const double dt = since.duration();
  way.d_state.middleRows<3>(row::kTheta) =
      0.5 * dt * dt * skew(Vector3d(0, 0, -gravity_mps2)).transpose() * axes;
  way.d_state.middleRows<3>(row::kV) = dt * axes;
  way.d_state.middleRows<3>(row::kBg) = (R * since.dp_dbg()).transpose() * axes;
  way.d_state.middleRows<3>(row::kBa) = (R * since.dp_dba()).transpose() * axes;
  const Matrix3d in_body = R.transpose() * axes;
  const auto noise = since.covariance().middleCols<3>(6);  // with that of the position
  way.noise_m2 = in_body.transpose() * noise.middleRows<3>(6) * in_body;
  way.with_p = R * noise.middleRows<3>(6) * in_body;
  way.with_v = R * noise.middleRows<3>(3) * in_body;
  return way;
}

void take_wheel(const NavState& x, const StateMatrix& covariance, const ImuPreintegration& since,
                double gravity_mps2, const PredictedWay& way, const WheelWaySince& wheel,
                double robust_threshold, OdometryEstimate& estimate) {
  const auto delta = since.delta(x.gyro_bias, x.accel_bias);
  const NavState y = moved_by(x, since.duration(), delta, gravity_mps2);
  const Vector3d rolled_m(wheel.moved_m.x() / x.wheel_scale, wheel.moved_m.y(), wheel.moved_m.z());
  const Vector3d innovation = rolled_m - way.moved_m;
  auto H = way.d_state;  // of the innovation, by the state's error
  H(row::kScale, 0) += rolled_m.x() / x.wheel_scale;
  const Eigen::Matrix<double, kStateDim, 3> with_state = covariance * H;
  Matrix3d S = H.transpose() * with_state + way.noise_m2;
  S.diagonal() += wheel.sigma_m.cwiseAbs2();
  // The kernel's weight, as variance of the distance.
  const double c2 = robust_threshold * robust_threshold;
  if (c2 > 0) S(0, 0) += innovation.x() * innovation.x() / c2;

  // Covariance of phi, p and v with the innovation. Noise of the velocity at the way's end has
  // moved the position since then.
  const PropagationJacobian F = jacobian(x, y, since, delta);
  Matrix93d with = F * with_state, moved_since = movement_since(x, F) * with_state;
  for (Matrix93d* m : {&with, &moved_since}) {
    m->middleRows<3>(3) += way.with_p + to_seconds(y.time - way.time) * way.with_v;
    m->bottomRows<3>() += way.with_v;
  }
  const Matrix3d Ry = y.R_odom_body();
  const auto pose = [](const Matrix93d& m) {
    return (Eigen::Matrix<double, 6, 3>() << m.middleRows<3>(3), m.topRows<3>()).finished();
  };
  const auto velocity = [&](const Matrix93d& m) -> Matrix3d {
    return Ry.transpose() * (skew(y.v_odom) * m.topRows<3>() + m.bottomRows<3>());
  };
  const Matrix93d gain = moved_since * S.inverse();
  estimate.p_odom_body += gain.middleRows<3>(3) * innovation;
  estimate.v_body += velocity(gain) * innovation;
  const auto corrected = [&S](auto& covariance, const auto& k, const auto& c) {
    covariance += k * S * k.transpose() - k * c.transpose() - c * k.transpose();
  };
  corrected(estimate.pose_covariance, pose(gain), pose(with));
  corrected(estimate.velocity_covariance, velocity(gain), velocity(with));
}

}  // namespace gprodom
