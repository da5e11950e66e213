// Least squares over a window: the interface, and the two that solve it. docs/estimation.md.
#pragma once

#include <cmath>
#include <memory>

#include "estimation/normal_equations.h"
#include "estimation/window.h"

namespace gprodom {

struct SolverOptions {
  int max_iterations = 4;     // with 50 the errors are the same (docs/lessons.md)
  double convergence = 1e-3;  // stop once a step is expected to lower the cost by less
};

struct SolveSummary {
  bool usable = false;  // false: the states are those before the solve
  int steps = 0;        // tried
  int accepted = 0;
  double cost = 0.0;  // half the sum of squared (robust) residuals
  // The covariance of position or heading is smaller than the prior's. No factor measured them, so
  // this is a defect of the solver or of a factor.
  bool unfounded = false;
};

// Further steps beyond the cap while none has been accepted, each with more damping, because a
// failed solve costs the whole window.
constexpr int kMoreSteps = 8;

inline bool may_step(const SolveSummary& summary, const SolverOptions& options) {
  return summary.steps < options.max_iterations + (summary.accepted > 0 ? 0 : kMoreSteps);
}

// Whether a step is accepted: the cost has not risen by more than rounding.
inline bool not_raised(double cost, double before) {
  return std::isfinite(cost) && cost <= before * (1 + 1e-12) + 1e-9;
}

// Gauss-Newton, with damping if a step fails to lower the cost. Both solvers take the same steps,
// except for rounding.
class WindowSolver {
 public:
  virtual ~WindowSolver() = default;

  // Moves the window's states and the linearisation point of its prior to the solution, and leaves
  // the elimination there in `equations`. If the result is not usable, both are undefined. Between
  // two calls a window may gain states and links, and lose its oldest states with their links; then
  // its prior has changed too.
  virtual SolveSummary solve(Window& window, NormalEquations& equations) = 0;
};

// A ceres::Problem that persists from solve to solve.
std::unique_ptr<WindowSolver> make_ceres_solver(const SolverOptions& options);

// One block elimination for each step, with no symbolic analysis and nothing kept between solves:
// a third of Ceres' time.
std::unique_ptr<WindowSolver> make_chain_solver(const SolverOptions& options);

}  // namespace gprodom
