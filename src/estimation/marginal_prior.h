// The prior that marginalised states leave on the remaining ones, in square-root form.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimation/nav_state.h"

namespace gprodom {

// A fixed scale needs a finite weight too: 0.1 ppm.
constexpr double kFixedScaleSigma = 1e-7;

// Residual A [local(x0_1, x_1); ...; local(x0_n, x_n)] + b over the oldest n states of the window,
// unit variance per row. A was made at x0: its null space (global position and yaw, less what the
// origin fixes) is the same at every x, see nav_state.h.
struct MarginalPrior {
  std::vector<NavState> x0;
  Eigen::MatrixXd A;  // (rows, 16 n)
  Eigen::VectorXd b;  // (rows)

  // Adds a row on the first state's wheel scale, with this standard deviation.
  void add_scale(double scale, double sigma);

  // Position (x, y) and heading of the first state are known to kFreePlace only. Of a prior of one
  // state, whose place has no correlation with the rest of it.
  void free_place();

  // Of the error of its one state.
  StateMatrix covariance() const;

  int states() const { return static_cast<int>(x0.size()); }

  // x points to the n states. Where J is not null it receives d residual / d (charts at x).
  void evaluate(const NavState* x, Eigen::VectorXd& r, Eigen::MatrixXd* J) const;

  // Moves x0 to x, with the residual there, and keeps A. To first order this is the same prior,
  // with an unchanged null space. With d local / d x instead, the strong information on tilt and
  // velocity, times their change, would become information on yaw and position.
  void move_to(const NavState* x);

  // Expresses the prior in a frame whose origin is moved by `by`. The chart rotates about the
  // origin, so rho there is rho + theta x by.
  void shift_origin(const Eigen::Vector3d& by);

  // Information on the common heading and position (x, y, z) of all states, 1/rad^2 and 1/m^2.
  Eigen::Vector4d common_information() const;
};

// Prior on a state, with a covariance that must be positive definite.
MarginalPrior gaussian_prior(const NavState& state, const StateMatrix& covariance);

// Eliminates the first 16 columns of the least-squares problem |J d + r|^2 by QR. The rest is a
// problem in the other columns, with upper-triangular A and b of at most as many rows as columns.
void eliminate_first_state(Eigen::MatrixXd J, Eigen::VectorXd r, Eigen::MatrixXd& A,
                           Eigen::VectorXd& b);

}  // namespace gprodom
