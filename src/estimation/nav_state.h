// The state of the robot at one instant, and the chart in which the estimator corrects it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

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

  Eigen::Matrix3d R_odom_body() const;

  bool finite() const;
};

// The error rotates and shifts all of `odom` (it acts from the left):
//   R = Exp(theta) R^,  p = Exp(theta) p^ + rho,  v = Exp(theta) v^ + nu,  rest additive.
// Global position and yaw, which nothing observes, are then the same directions
// (rho = t, theta = psi e_z) for every state at every linearisation point, so no
// first-estimate bookkeeping is needed for consistency. docs/estimation.md, "Error state".
NavState retract(const NavState& x, const StateVector& d);

// The d for which retract(x, d) is y.
StateVector local(const NavState& x, const NavState& y);

// d local(x, retract(y, e)) / d e at e = 0.
StateMatrix local_jacobian(const NavState& x, const NavState& y);

}  // namespace gprodom
