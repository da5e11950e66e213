// What marginalised states leave behind on those that remain, as a square root.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimation/nav_state.h"

namespace gprodom {

// Residual A [local(x0_1, x_1); ...; local(x0_n, x_n)] + b over the oldest n states of the window,
// unit variance per row. A was made at x0: its null space (global position and yaw, less what the
// origin fixes) is the same at every x, see nav_state.h.
struct MarginalPrior {
  std::vector<NavState> x0;
  Eigen::MatrixXd A;  // (rows, 16 n)
  Eigen::VectorXd b;  // (rows)

  // Of the first state's wheel scale, beside what is known, with one standard deviation.
  void add_scale(double scale, double sigma);

  int states() const { return static_cast<int>(x0.size()); }

  // x points to the n states. Where J is not null it receives d residual / d (charts at x).
  void evaluate(const NavState* x, Eigen::VectorXd& r, Eigen::MatrixXd* J) const;

  // Takes x for x0, with the residual at it, and keeps A: to first order the same prior, with
  // the null space that it had. Where d local / d x were used instead, what is known well (tilt,
  // velocity), times how far it has moved, would count as information on yaw and position.
  void move_to(const NavState* x);

  // The same prior of states whose frame's origin lies `by` further on, in the chart there. The
  // chart turns about the origin: rho there is rho + theta x by.
  void shift_origin(const Eigen::Vector3d& by);

  // Of heading and position (x, y, z) of all states together, 1/rad^2 and 1/m^2.
  Eigen::Vector4d common_information() const;
};

// Removes the first 16 columns of the least-squares problem |J d + r|^2 by QR: what is left of it
// on the other columns, as upper-triangular A and b with at most as many rows as columns.
void eliminate_first_state(Eigen::MatrixXd J, Eigen::VectorXd r, Eigen::MatrixXd& A,
                           Eigen::VectorXd& b);

}  // namespace gprodom
