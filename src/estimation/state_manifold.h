// A state for Ceres: one parameter block on a manifold with the chart of nav_state.h.
#pragma once

#include <ceres/manifold.h>

#include <array>

#include "estimation/factors.h"
#include "estimation/nav_state.h"
#include "estimation/predict.h"

namespace gprodom {

// Quaternion (w, x, y, z), position, velocity, gyro bias, accel bias, scale: units of NavState.
namespace ambient {
constexpr int kQ = 0, kP = 4, kV = 7, kBg = 10, kBa = 13, kScale = 16, kSize = 17;
}
using StateParameters = std::array<double, ambient::kSize>;

void to_parameters(const NavState& state, double* parameters);
NavState from_parameters(const double* parameters);  // without time
NavState with_parameters(const NavState& state, const double* parameters);

// Jacobian of the parameters of y. plain: Jacobian of its plain errors (phi, dp, dv) by the same
// variables; biases and scale are additive.
using ParameterJacobian = Eigen::Matrix<double, ambient::kSize, kStateDim, Eigen::RowMajor>;
ParameterJacobian parameter_jacobian(const NavState& y, const PropagationJacobian& plain);

class StateManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return ambient::kSize; }
  int TangentSize() const override { return kStateDim; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// Derivatives in the chart at x, as derivatives by the parameters: J d(local(x, y)) / dy at y = x.
// `ambient`: rows of 17, as many as J has.
void to_ambient(const NavState& x, const Jacobian& J, double* ambient);

}  // namespace gprodom
