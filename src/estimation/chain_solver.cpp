// Gauss-Newton on the chain of states, with one block elimination for each step. No symbolic
// analysis, and nothing is kept between solves.
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/window_solver.h"

namespace gprodom {

namespace {

class ChainSolver final : public WindowSolver {
 public:
  explicit ChainSolver(const SolverOptions& options) : options_(options) {}
  SolveSummary solve(Window& window, NormalEquations& equations) override;

 private:
  SolverOptions options_;
};

// A trial is linearised at once, as it is hardly ever refused.
SolveSummary ChainSolver::solve(Window& window, NormalEquations& equations) {
  SolveSummary summary;
  std::vector<StateVector> step;
  std::vector<NavState> before(window.states.size());
  double damping = 0;
  summary.cost = equations.linearise(window);
  while (may_step(summary, options_)) {
    if (!std::isfinite(summary.cost)) return summary;
    ++summary.steps;
    if (!equations.eliminate(damping)) {
      damping = std::max(1e-6, 10 * damping);
      continue;
    }
    const double expected = equations.solve_step(step);
    window.states.swap(before);
    std::transform(before.begin(), before.end(), step.begin(), window.states.begin(), retract);
    MarginalPrior prior_before = window.prior;
    window.prior.move_to(window.states.data());
    const double cost = equations.linearise(window);
    if (not_raised(cost, summary.cost)) {
      ++summary.accepted;
      summary.cost = cost;
      summary.usable = true;
      damping = 0;
      if (expected < options_.convergence) break;
    } else {
      window.states.swap(before);
      window.prior = std::move(prior_before);
      equations.linearise(window);
      damping = std::max(1e-6, 10 * damping);
    }
  }
  summary.usable = summary.usable && equations.eliminate(0);
  return summary;
}

}  // namespace

std::unique_ptr<WindowSolver> make_chain_solver(const SolverOptions& options) {
  return std::make_unique<ChainSolver>(options);
}

}  // namespace gprodom
