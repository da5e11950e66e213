// The state of the robot at one instant, and the chart in which the estimator corrects it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "estimation/so3.h"
#include "gprodom/types.h"

namespace gprodom {

// Rows of the 16-dimensional error: rotation, position, velocity, gyro bias, accel bias, scale.
namespace row {
constexpr int kTheta = 0, kP = 3, kV = 6, kBg = 9, kBa = 12, kScale = 15;
// Heading and position (x, y, z): an error common to all states is not observable.
constexpr int kUnmeasured[] = {kTheta + 2, kP, kP + 1, kP + 2};
}  // namespace row
constexpr int kStateDim = 16;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;
using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

// m/s^2. Gravity differs from it by 0.03 at most, from the equator to the poles: the
// accelerometer's bias takes that up.
constexpr double kStandardGravity = 9.80665;

// m/s^2, of the accelerometer's bias before anything is known of it: 3 mg, as of a calibrated MEMS
// sensor. A larger bias shows in the size of the force at rest.
constexpr double kAccelBiasSigma = 0.03;

// 1/sqrt(s), random walk of the wheel's scale: 6e-5 in an hour, as tyres warm up and wear. What
// changes faster is slip, which is modelled by itself.
constexpr double kWheelScaleWalk = 1e-6;

struct NavState {
  TimeNs time = 0;
  Eigen::Quaterniond q_odom_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d v_odom = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  double wheel_scale = 1.0;  // reported over true distance

  Eigen::Matrix3d R_odom_body() const { return q_odom_body.toRotationMatrix(); }

  bool finite() const {
    return q_odom_body.coeffs().allFinite() && p_odom.allFinite() && v_odom.allFinite() &&
           gyro_bias.allFinite() && accel_bias.allFinite() && std::isfinite(wheel_scale);
  }
};

// The error rotates and shifts all of `odom` (it acts from the left):
//   R = Exp(theta) R^,  p = Exp(theta) p^ + rho,  v = Exp(theta) v^ + nu,  rest additive.
// Global position and yaw, which nothing observes, are then the same directions
// (rho = t, theta = psi e_z) for every state at every linearisation point, so no
// first-estimate bookkeeping is needed for consistency. docs/estimation.md, "Error state".
inline NavState retract(const NavState& x, const StateVector& d) {
  const Eigen::Quaterniond dq = so3::exp(d.segment<3>(row::kTheta));
  NavState y = x;
  y.q_odom_body = (dq * x.q_odom_body).normalized();
  y.p_odom = dq * x.p_odom + d.segment<3>(row::kP);
  y.v_odom = dq * x.v_odom + d.segment<3>(row::kV);
  y.gyro_bias += d.segment<3>(row::kBg);
  y.accel_bias += d.segment<3>(row::kBa);
  y.wheel_scale += d[row::kScale];
  return y;
}

// The d for which retract(x, d) is y.
inline StateVector local(const NavState& x, const NavState& y) {
  const Eigen::Quaterniond dq = y.q_odom_body * x.q_odom_body.conjugate();
  StateVector d;
  d.segment<3>(row::kTheta) = so3::log(dq);
  d.segment<3>(row::kP) = y.p_odom - dq * x.p_odom;
  d.segment<3>(row::kV) = y.v_odom - dq * x.v_odom;
  d.segment<3>(row::kBg) = y.gyro_bias - x.gyro_bias;
  d.segment<3>(row::kBa) = y.accel_bias - x.accel_bias;
  d[row::kScale] = y.wheel_scale - x.wheel_scale;
  return d;
}

// d local(x, retract(y, e)) / d e at e = 0.
inline StateMatrix local_jacobian(const NavState& x, const NavState& y) {
  const StateVector d = local(x, y);
  StateMatrix j = StateMatrix::Identity();
  j.block<3, 3>(row::kTheta, row::kTheta) = so3::left_jacobian_inverse(d.segment<3>(row::kTheta));
  j.block<3, 3>(row::kP, row::kTheta) = -so3::skew(d.segment<3>(row::kP));
  j.block<3, 3>(row::kV, row::kTheta) = -so3::skew(d.segment<3>(row::kV));
  return j;
}

}  // namespace gprodom
