// Least squares over a window: the interface, and the two that solve it. docs/estimation.md.
#pragma once

#include <cmath>
#include <memory>

#include "estimation/normal_equations.h"
#include "estimation/window.h"

namespace gprodom {

struct SolverOptions {
  int max_iterations = 4;
  double convergence = 1e-3;  // stop once a step is expected to lower the cost by less
};

struct SolveSummary {
  bool usable = false;  // false: the states are those before the solve
  int steps = 0;        // tried
  int accepted = 0;
  double cost = 0.0;  // half the sum of squared (robust) residuals
  // The covariance claims to know place or heading better than the prior did. No factor measured
  // them, so this is a fault of the solver or of a factor.
  bool unfounded = false;
};

// Steps beyond the cap while none is accepted, each with more damping than the last: a failure
// costs the whole window.
constexpr int kMoreDamping = 8;

inline bool may_step(const SolveSummary& summary, const SolverOptions& options) {
  return summary.steps < options.max_iterations + (summary.accepted > 0 ? 0 : kMoreDamping);
}

// Whether a step may stand. Rounding of a large cost is no reason to refuse one.
inline bool not_raised(double cost, double before) {
  return std::isfinite(cost) && cost <= before * (1 + 1e-12) + 1e-9;
}

// Gauss-Newton with damping where a step fails to lower the cost. Both solvers take the same steps
// but for rounding.
class WindowSolver {
 public:
  virtual ~WindowSolver() = default;

  // Moves the window's states and its prior's linearisation to the solution, and leaves the
  // elimination there in `equations`. Where it is not usable, what is in both is of no use.
  // Between two calls a window may gain states and links, and lose its oldest states with their
  // links; then its prior is another.
  virtual SolveSummary solve(Window& window, NormalEquations& equations) = 0;
};

// A ceres::Problem that lives on from solve to solve.
std::unique_ptr<WindowSolver> make_ceres_solver(const SolverOptions& options);

// One elimination a step, no analysis and no memory of earlier solves: for slow processors, or many
// states a second.
std::unique_ptr<WindowSolver> make_chain_solver(const SolverOptions& options);

}  // namespace gprodom
