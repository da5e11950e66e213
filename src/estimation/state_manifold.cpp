#include "estimation/state_manifold.h"

#include "estimation/kernels/so3.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using so3::skew;

namespace {

// With a turn by theta from the left q moves by M theta / 2; M's columns are orthonormal.
Eigen::Matrix<double, 4, 3> left_turn(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> m;
  m << -q.x(), -q.y(), -q.z(),  //
      q.w(), q.z(), -q.y(),     //
      -q.z(), q.w(), q.x(),     //
      q.y(), -q.x(), q.w();
  return m;
}

constexpr int kLinear = kStateDim - row::kBg;  // rows that are additive

}  // namespace

void to_parameters(const NavState& x, double* p) {
  p[0] = x.q_odom_body.w();
  Eigen::Map<Vector3d>{p + 1} = x.q_odom_body.vec();
  Eigen::Map<Vector3d>{p + ambient::kP} = x.p_odom;
  Eigen::Map<Vector3d>{p + ambient::kV} = x.v_odom;
  Eigen::Map<Vector3d>{p + ambient::kBg} = x.gyro_bias;
  Eigen::Map<Vector3d>{p + ambient::kBa} = x.accel_bias;
  p[ambient::kScale] = x.wheel_scale;
}

NavState from_parameters(const double* p) {
  NavState x;
  x.q_odom_body = Eigen::Quaterniond(p[0], p[1], p[2], p[3]);
  x.p_odom = Eigen::Map<const Vector3d>(p + ambient::kP);
  x.v_odom = Eigen::Map<const Vector3d>(p + ambient::kV);
  x.gyro_bias = Eigen::Map<const Vector3d>(p + ambient::kBg);
  x.accel_bias = Eigen::Map<const Vector3d>(p + ambient::kBa);
  x.wheel_scale = p[ambient::kScale];
  return x;
}

NavState with_parameters(const NavState& state, const double* parameters) {
  NavState x = from_parameters(parameters);
  x.time = state.time;
  return x;
}

bool StateManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  to_parameters(retract(from_parameters(x), Eigen::Map<const StateVector>(delta)), x_plus_delta);
  return true;
}

ParameterJacobian parameter_jacobian(const NavState& y, const PropagationJacobian& plain) {
  ParameterJacobian J = ParameterJacobian::Zero();
  J.middleRows<4>(ambient::kQ) = 0.5 * left_turn(y.q_odom_body) * plain.topRows<3>();
  J.middleRows<6>(ambient::kP) = plain.bottomRows<6>();
  J.bottomRightCorner<kLinear, kLinear>().setIdentity();
  return J;
}

bool StateManifold::PlusJacobian(const double* x, double* jacobian) const {
  const NavState state = from_parameters(x);
  PropagationJacobian plain = PropagationJacobian::Zero();
  plain.leftCols<9>().setIdentity();
  plain.block<3, 3>(row::kP, row::kTheta) = -skew(state.p_odom);
  plain.block<3, 3>(row::kV, row::kTheta) = -skew(state.v_odom);
  Eigen::Map<ParameterJacobian>{jacobian} = parameter_jacobian(state, plain);
  return true;
}

bool StateManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<StateVector>{y_minus_x} = local(from_parameters(x), from_parameters(y));
  return true;
}

bool StateManifold::MinusJacobian(const double* x, double* jacobian) const {
  Jacobian rows;
  rows.setZero(8, kStateDim);  // in two halves, since a Jacobian has nine rows at most
  for (int half = 0; half < 2; ++half) {
    rows.setZero();
    rows.middleCols<8>(8 * half).setIdentity();
    to_ambient(from_parameters(x), rows, jacobian + 8 * half * ambient::kSize);
  }
  return true;
}

void to_ambient(const NavState& x, const Jacobian& J, double* ambient_rows) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, ambient::kSize, Eigen::RowMajor>;
  Eigen::Map<Rows> out(ambient_rows, J.rows(), ambient::kSize);
  const Eigen::Matrix<double, 3, 4> turn = 2 * left_turn(x.q_odom_body).transpose();
  const Matrix3d P = skew(x.p_odom), V = skew(x.v_odom);
  for (int i = 0; i < J.rows(); ++i) {
    // Of p and v themselves: what theta does to them is taken off again.
    const Eigen::RowVector3d theta = J.block<1, 3>(i, row::kTheta) + J.block<1, 3>(i, row::kP) * P +
                                     J.block<1, 3>(i, row::kV) * V;
    out.block<1, 4>(i, ambient::kQ) = theta * turn;
  }
  out.rightCols<kStateDim - row::kP>() = J.rightCols<kStateDim - row::kP>();
}

}  // namespace gprodom
