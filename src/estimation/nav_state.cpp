#include "estimation/nav_state.h"

#include <cmath>

#include "estimation/kernels/so3.h"

namespace gprodom {

Eigen::Matrix3d NavState::R_odom_body() const { return q_odom_body.toRotationMatrix(); }

bool NavState::finite() const {
  return q_odom_body.coeffs().allFinite() && p_odom.allFinite() && v_odom.allFinite() &&
         gyro_bias.allFinite() && accel_bias.allFinite() && std::isfinite(wheel_scale);
}

NavState retract(const NavState& x, const StateVector& d) {
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

StateVector local(const NavState& x, const NavState& y) {
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

StateMatrix local_jacobian(const NavState& x, const NavState& y) {
  const StateVector d = local(x, y);
  StateMatrix j = StateMatrix::Identity();
  j.block<3, 3>(row::kTheta, row::kTheta) = so3::left_jacobian_inverse(d.segment<3>(row::kTheta));
  j.block<3, 3>(row::kP, row::kTheta) = -so3::skew(d.segment<3>(row::kP));
  j.block<3, 3>(row::kV, row::kTheta) = -so3::skew(d.segment<3>(row::kV));
  return j;
}

}  // namespace gprodom
