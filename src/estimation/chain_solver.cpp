// Gauss-Newton on the chain of states, with one block elimination for each step. No symbolic
// analysis, and nothing is kept between solves.
#include <algorithm>
#include <cmath>

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

SolveSummary ChainSolver::solve(Window& window, NormalEquations& equations) {
  SolveSummary summary;
  std::vector<StateVector> step;
  std::vector<NavState> trial(window.states.size());
  double damping = 0, expected = 0;
  summary.cost = equations.linearise(window);
  while (may_step(summary, options_)) {
    if (!std::isfinite(summary.cost)) return summary;
    if (!equations.eliminate(damping)) {
      damping = std::max(1e-6, 10 * damping);
      ++summary.steps;
      continue;
    }
    expected = equations.solve_step(step);
    std::transform(window.states.begin(), window.states.end(), step.begin(), trial.begin(),
                   retract);
    const double trial_cost = window_cost(window, trial);
    ++summary.steps;
    if (not_raised(trial_cost, summary.cost)) {
      ++summary.accepted;
      window.states.swap(trial);
      window.prior.move_to(window.states.data());
      summary.cost = trial_cost;
      summary.usable = true;
      damping = 0;
      equations.linearise(window);
      if (expected < options_.convergence) break;
    } else {
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
