// The window as a ceres::Problem that persists: an update adds new blocks and removes those that
// have left the window. It uses one thread and limits iterations, not time, so that a replay
// repeats to the byte.
#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "estimation/factor_cost.h"
#include "estimation/state_manifold.h"
#include "estimation/window_solver.h"

namespace gprodom {

namespace {

// Levenberg-Marquardt adds 1 / radius of the diagonal: first no more than rounding, and a millionth
// after a step that did not lower the cost.
constexpr double kUndampedRadius = 1e16, kDampedRadius = 1e6;

// Counts steps. Ends Ceres' loop if the next step is expected to lower the cost by little, or if
// the damping must change: after a failed step, and after the first damped step that was accepted.
class StopRule final : public ceres::IterationCallback {
 public:
  StopRule(const SolverOptions& options, SolveSummary& summary)
      : options_(options), summary_(summary) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& step) override {
    if (step.iteration == 0) return ceres::SOLVER_CONTINUE;  // where the solve begins
    ++summary_.steps;
    // Ceres refuses a step that changes the cost by rounding only: it has converged.
    const bool arrived = step.step_is_valid && !step.step_is_successful &&
                         not_raised(step.cost, step.cost + step.cost_change);
    failed_ = !step.step_is_successful && !arrived;
    if (!failed_) ++summary_.accepted;
    const double expected = step.cost_change / step.relative_decrease;
    converged_ = arrived || (step.step_is_successful && expected < options_.convergence);
    return !may_go_on() || failed_ != damped_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                              : ceres::SOLVER_CONTINUE;
  }

  // The initial radius of the next run of Ceres' loop.
  double radius() {
    damped_ = failed_;
    return damped_ ? kDampedRadius : kUndampedRadius;
  }
  bool converged() const { return converged_; }
  bool may_go_on() const { return !converged_ && may_step(summary_, options_); }

 private:
  const SolverOptions& options_;
  SolveSummary& summary_;
  bool failed_ = false, damped_ = false, converged_ = false;
};

// Moves the prior's linearisation point along with the states (MarginalPrior::move_to). It does so
// before each linearisation, so never to a point that may still be refused.
class PriorFollower final : public ceres::EvaluationCallback {
 public:
  // Both must outlive it. `states` begins with the prior's.
  PriorFollower(MarginalPrior& prior, const std::deque<StateParameters>& states)
      : prior_(prior), states_(states) {}

  void PrepareForEvaluation(bool evaluate_jacobians, bool /*new_point*/) override {
    if (!evaluate_jacobians) return;
    std::vector<NavState> x;
    x.reserve(prior_.x0.size());
    for (int i = 0; i < prior_.states(); ++i)
      x.push_back(with_parameters(prior_.x0[i], states_[i].data()));
    prior_.move_to(x.data());
  }

 private:
  MarginalPrior& prior_;
  const std::deque<StateParameters>& states_;
};

ceres::Problem::Options problem_options(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options options;
  options.evaluation_callback = callback;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.enable_fast_removal = true;
  return options;
}

class CeresSolver final : public WindowSolver {
 public:
  explicit CeresSolver(const SolverOptions& options)
      : options_(options), follower_(*prior_, states_), problem_(problem_options(&follower_)) {}
  SolveSummary solve(Window& window, NormalEquations& equations) override;

 private:
  void forget_before(Window::StateId first);
  void follow(const Window& window);
  bool minimise(SolveSummary& summary);
  double* parameters(Window::StateId id) {
    return states_[static_cast<size_t>(id - first_id_)].data();
  }

  struct Tied {
    Window::StateId a;
    std::vector<ceres::ResidualBlockId> blocks;
  };

  SolverOptions options_;
  StateManifold manifold_;
  std::deque<StateParameters> states_;  // a deque does not move its elements
  std::shared_ptr<MarginalPrior> prior_ = std::make_shared<MarginalPrior>();
  PriorFollower follower_;
  ceres::Problem problem_;
  Window::StateId first_id_ = 0;
  std::vector<Tied> tied_;
  std::int64_t newest_link_ = -1;
  ceres::ResidualBlockId prior_block_ = nullptr;
};

// Removes residual blocks one by one, in order. Ceres would remove those of a state in the order of
// their addresses, and then each run would add up sums in another order.
void CeresSolver::forget_before(Window::StateId first) {
  if (prior_block_) problem_.RemoveResidualBlock(prior_block_);
  prior_block_ = nullptr;
  std::vector<Tied> kept;
  for (Tied& tied : tied_) {
    if (tied.a < first)
      for (ceres::ResidualBlockId block : tied.blocks) problem_.RemoveResidualBlock(block);
    else
      kept.push_back(std::move(tied));
  }
  tied_.swap(kept);
  for (; first_id_ < first; ++first_id_) {
    problem_.RemoveParameterBlock(states_.front().data());
    states_.pop_front();
  }
}

// Updates the problem to the window.
void CeresSolver::follow(const Window& window) {
  if (first_id_ < window.first_id) forget_before(window.first_id);
  for (size_t i = 0; i < window.states.size(); ++i) {
    if (i == states_.size()) {
      states_.emplace_back();
      problem_.AddParameterBlock(states_.back().data(), ambient::kSize, &manifold_);
    }
    to_parameters(window.states[i], states_[i].data());
  }
  *prior_ = window.prior;
  if (!prior_block_) {
    std::vector<double*> held;
    held.reserve(window.prior.x0.size());
    for (int i = 0; i < window.prior.states(); ++i) held.push_back(states_[i].data());
    prior_block_ = add_to(problem_, prior_, held);
  }
  std::int64_t newest = newest_link_;
  for (const Window::Link& link : window.links) {
    if (link.number <= newest_link_) continue;
    newest = std::max(newest, link.number);
    tied_.push_back(
        {link.a, add_to(problem_, link.factor, parameters(link.a), parameters(link.b))});
  }
  newest_link_ = newest;
}

// Runs Ceres until a step is expected to change little, or the cap. false: no usable solution.
bool CeresSolver::minimise(SolveSummary& summary) {
  StopRule rule(options_, summary);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  // Only our own stopping rule applies.
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0.0;
  options.min_relative_decrease = 0.0;
  options.callbacks.push_back(&rule);
  ceres::Solver::Summary told;
  do {
    options.initial_trust_region_radius = rule.radius();
    options.max_num_iterations = options_.max_iterations + kMoreSteps;  // the rule's cap is lower
    ceres::Solve(options, &problem_, &told);
  } while (told.termination_type == ceres::USER_SUCCESS && rule.may_go_on());
  summary.cost = told.final_cost;
  // If no step lowered the cost, the solution is usable only if the states are at the minimum.
  return told.IsSolutionUsable() &&
         (summary.accepted > 0 || rule.converged() || told.termination_type == ceres::CONVERGENCE);
}

SolveSummary CeresSolver::solve(Window& window, NormalEquations& equations) {
  SolveSummary summary;
  if (!std::isfinite(window_cost(window))) return summary;
  follow(window);
  if (!minimise(summary)) return summary;
  for (size_t i = 0; i < states_.size(); ++i)
    window.states[i] = with_parameters(window.states[i], states_[i].data());
  window.prior = *prior_;
  equations.linearise(window);
  summary.usable = equations.eliminate(0);
  return summary;
}

}  // namespace

std::unique_ptr<WindowSolver> make_ceres_solver(const SolverOptions& options) {
  return std::make_unique<CeresSolver>(options);
}

}  // namespace gprodom
