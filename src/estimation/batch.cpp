#include "estimation/batch.h"

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/product_manifold.h>
#include <ceres/solver.h>

#include <cmath>
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

size_t Batch::add_fix(Fix fix) {
  if (fix.a >= fix.b || fix.b >= states_.size() || (fix.before && *fix.before >= fixes_.size()) ||
      fix.antenna >= antennas_.size())
    throw std::invalid_argument("Batch: no such states, fix before or antenna");
  fixes_.push_back(std::move(fix));
  return fixes_.size() - 1;
}

void Batch::add_way(Way way) {
  if (way.a >= way.b || way.b >= states_.size())
    throw std::invalid_argument("Batch: no such states");
  ways_.push_back(std::move(way));
}

void Batch::set_scale_walk(double sigma) {
  for (Link& link : links_) {
    const double seconds = to_seconds(states_[link.b].time - states_[link.a].time);
    if (auto walks = link.factor->with_scale_step(sigma * std::sqrt(seconds)))
      link.factor = std::move(walks);
  }
}

void Batch::set_slips(const std::vector<std::optional<double>>& slips) {
  for (Link& link : links_) {
    if (link.a >= slips.size() || !slips[link.a]) continue;
    if (auto slipped = link.factor->with_slip(*slips[link.a])) link.factor = std::move(slipped);
  }
}

namespace {

ceres::Solver::Options solver_options(int max_iterations) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = max_iterations;
  solver.function_tolerance = 1e-16;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-12;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

std::vector<NavState> Batch::solve(const Options& options,
                                   std::vector<Eigen::Vector3d>* antennas) const {
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
  MarginalPrior prior = prior_;
  if (held_scale_) prior.add_scale(*held_scale_, kFixedScaleSigma);
  add_to(problem, std::make_shared<const MarginalPrior>(std::move(prior)), {x[0].data()});
  for (const Link& link : links_)
    add_to(problem, link.factor, x[link.a].data(), x[link.b].data(), options.robust);
  for (const Way& way : ways_) {
    std::vector<double*> states;
    for (size_t i = way.a; i <= way.b; ++i) states.push_back(x[i].data());
    add_to(problem, way, states);
  }
  std::vector<Eigen::Vector3d> unknown(antennas_.size(), Eigen::Vector3d::Zero());
  for (size_t i = 0; i < unknown.size(); ++i) add_to(problem, antennas_[i], unknown[i].data());
  std::vector<Eigen::Vector2d> lasting(fixes_.size(), Eigen::Vector2d::Zero());
  for (size_t i = 0; i < fixes_.size(); ++i) {
    const Fix& fix = fixes_[i];
    double* before = fix.before ? lasting[*fix.before].data() : nullptr;
    add_to(
        problem, fix,
        {x[fix.a].data(), x[fix.b].data(), lasting[i].data(), before, unknown[fix.antenna].data()});
  }

  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(options.max_iterations), &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw std::runtime_error("batch solution failed: " + summary.message);

  if (antennas) *antennas = std::move(unknown);
  std::vector<NavState> solved;
  solved.reserve(states_.size());
  for (size_t i = 0; i < states_.size(); ++i)
    solved.push_back(with_parameters(states_[i], x[i].data()));
  return solved;
}

}  // namespace gprodom
