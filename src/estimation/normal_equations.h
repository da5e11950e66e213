// The normal equations of a window, and their elimination from the oldest state to the newest.
//
// States form a chain, and a factor reaches back a few states at most, so the equations are
// block-banded. One block Cholesky gives the Gauss-Newton step and the newest state's covariance.
#pragma once

#include <vector>

#include "estimation/window.h"

namespace gprodom {

class NormalEquations {
 public:
  double linearise(const Window& window);  // at the window's states; returns the cost
  bool eliminate(double damping);          // false where not positive definite

  // Computes the step to the minimum of the linearised cost. Returns the decrease that is expected.
  double solve_step(std::vector<StateVector>& step) const;

  // H^-1 d, for vectors of the chart of nav_state.h: one for each state.
  std::vector<StateVector> covariance_with(const std::vector<StateVector>& d) const;

  size_t states() const { return g_.size(); }

  // Covariance of the newest state, in the chart of nav_state.h.
  StateMatrix newest_covariance() const;

  // Information on the newest state's heading and position (x, y, z), 1/rad^2 and 1/m^2.
  Eigen::Vector4d newest_information() const;

 private:
  void shape(const Window& window);
  double add_prior(const Window& window);
  double substitute(std::vector<StateVector>& x) const;
  template <typename Blocks>
  auto& block(Blocks& m, size_t row, size_t column) const {
    return m[row * (bandwidth_ + 1) + (row - column)];
  }

  // Workspace, kept between solves. Only the lower triangle of diagonal blocks is used.
  size_t bandwidth_ = 1;
  std::vector<StateMatrix> H_,
      L_;                       // lower block band: row i holds columns i, i-1, ..., i-bandwidth
  std::vector<size_t> first_;   // per row the first column with a block: the envelope
  std::vector<StateVector> g_;  // gradient; all in units of their own
};

}  // namespace gprodom
