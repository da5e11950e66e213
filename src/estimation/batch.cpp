#include "estimation/batch.h"

#include <ceres/ceres.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace gprodom {

namespace {

NavState corrected(const NavState& start, const double* parameter) {
  return retract(start, Eigen::Map<const StateVector>(parameter));
}

// From derivatives in the chart at the corrected state to derivatives by the parameter.
template <typename Matrix>
void to_parameter(const NavState& start, const NavState& now, Matrix& J) {
  J = (J * local_jacobian(start, now).inverse()).eval();
}

// Cauchy's cost as a residual of its own: f with f^2 / 2 = rho(r), and df/dr.
std::pair<double, double> robustified(double r, double c) {
  if (c <= 0 || r == 0) return {r, 1.0};
  const double f = std::copysign(c * std::sqrt(std::log1p(r * r / (c * c))), r);
  return {f, r / (1 + r * r / (c * c)) / f};
}

class FactorCost final : public ceres::CostFunction {
 public:
  FactorCost(std::shared_ptr<const Factor> factor, const NavState& a, const NavState& b,
             bool robust)
      : factor_(std::move(factor)), a_(a), b_(b), robust_(robust) {
    set_num_residuals(factor_->dimension());
    *mutable_parameter_block_sizes() = {kStateDim, kStateDim};
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const NavState a = corrected(a_, parameters[0]), b = corrected(b_, parameters[1]);
    Residual r;
    Jacobian Ja, Jb;
    factor_->evaluate(a, b, r, jacobians ? &Ja : nullptr, jacobians ? &Jb : nullptr);
    if (jacobians) {
      to_parameter(a_, a, Ja);
      to_parameter(b_, b, Jb);
    }
    for (int i = 0; i < r.size(); ++i) {
      const auto [f, slope] = robustified(r[i], robust_ ? factor_->robust_threshold(i) : 0.0);
      residuals[i] = f;
      if (!jacobians) continue;
      const Jacobian* J[] = {&Ja, &Jb};
      for (int k = 0; k < 2; ++k)
        if (jacobians[k])
          Eigen::Map<Eigen::Matrix<double, 1, kStateDim>>(jacobians[k] + i * kStateDim) =
              slope * J[k]->row(i);
    }
    return true;
  }

 private:
  std::shared_ptr<const Factor> factor_;
  NavState a_, b_;
  bool robust_;
};

class PriorCost final : public ceres::CostFunction {
 public:
  PriorCost(const MarginalPrior& prior, const NavState& start) : prior_(prior), start_(start) {
    set_num_residuals(static_cast<int>(prior.A.rows()));
    *mutable_parameter_block_sizes() = {kStateDim};
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const NavState x = corrected(start_, parameters[0]);
    Eigen::VectorXd r;
    Eigen::MatrixXd J;
    prior_.evaluate(&x, r, jacobians ? &J : nullptr);
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    if (!jacobians || !jacobians[0]) return true;
    to_parameter(start_, x, J);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, kStateDim, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(jacobians[0], J.rows(), kStateDim) = J;
    return true;
  }

 private:
  MarginalPrior prior_;
  NavState start_;
};

}  // namespace

Batch::Batch(const NavState& first, MarginalPrior prior)
    : prior_(std::move(prior)), states_{first} {
  if (prior_.states() != 1) throw std::invalid_argument("Batch: the prior must hold one state");
}

void Batch::add_factor(size_t a, size_t b, std::shared_ptr<const Factor> factor) {
  if (a >= b || b >= states_.size()) throw std::invalid_argument("Batch: no such states");
  links_.push_back({a, b, std::move(factor)});
}

void Batch::set_slip(size_t a, double l) {
  for (Link& link : links_) {
    if (link.a != a) continue;
    if (auto slipped = link.factor->with_slip(l)) link.factor = std::move(slipped);
  }
}

std::vector<NavState> Batch::solve(const Options& options) const {
  std::vector<StateVector> corrections(states_.size(), StateVector::Zero());
  ceres::Problem problem;
  problem.AddResidualBlock(new PriorCost(prior_, states_[0]), nullptr, corrections[0].data());
  for (const Link& link : links_)
    problem.AddResidualBlock(
        new FactorCost(link.factor, states_[link.a], states_[link.b], options.robust), nullptr,
        corrections[link.a].data(), corrections[link.b].data());

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
    solved.push_back(corrected(states_[i], corrections[i].data()));
  return solved;
}

}  // namespace gprodom
