#include "estimation/batch.h"

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/product_manifold.h>
#include <ceres/solver.h>

#include <stdexcept>
#include <utility>

#include "estimation/factor_cost.h"
#include "estimation/state_manifold.h"

namespace gprodom {

Batch::Batch(const NavState& first, MarginalPrior prior)
    : prior_(std::move(prior)), states_{first} {
  if (prior_.states() != 1) throw std::invalid_argument("Batch: the prior must hold one state");
}

void Batch::add_factor(size_t a, size_t b, std::shared_ptr<const Factor> factor) {
  if (a >= b || b >= states_.size()) throw std::invalid_argument("Batch: no such states");
  links_.push_back({a, b, std::move(factor)});
}

void Batch::set_slips(const std::vector<std::optional<double>>& slips) {
  for (Link& link : links_) {
    if (link.a >= slips.size() || !slips[link.a]) continue;
    if (auto slipped = link.factor->with_slip(*slips[link.a])) link.factor = std::move(slipped);
  }
}

std::vector<NavState> Batch::solve(const Options& options) const {
  std::vector<StateParameters> x(states_.size());
  // Positions and velocities are additive here. With the chart of nav_state.h, which rotates about
  // the origin, a small rotation would be a long displacement far from the origin, and steps would
  // have to be small.
  ceres::ProductManifold<ceres::QuaternionManifold, ceres::EuclideanManifold<ambient::kSize - 4>>
      manifold;
  ceres::Problem::Options ownership;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (size_t i = 0; i < x.size(); ++i) {
    to_parameters(states_[i], x[i].data());
    problem.AddParameterBlock(x[i].data(), ambient::kSize, &manifold);
  }
  add_to(problem, std::make_shared<const MarginalPrior>(prior_), {x[0].data()});
  for (const Link& link : links_)
    add_to(problem, link.factor, x[link.a].data(), x[link.b].data(), options.robust);

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-16;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-12;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw std::runtime_error("batch solution failed: " + summary.message);

  std::vector<NavState> solved;
  solved.reserve(states_.size());
  for (size_t i = 0; i < states_.size(); ++i)
    solved.push_back(with_parameters(states_[i], x[i].data()));
  return solved;
}

}  // namespace gprodom
