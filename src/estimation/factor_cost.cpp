#include "estimation/factor_cost.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/normal_prior.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "estimation/rolled_way.h"
#include "estimation/state_manifold.h"

namespace gprodom {

namespace {

// Residuals of states in a row. Not finite: Ceres takes it for a failed evaluation.
class StatesCost : public ceres::CostFunction {
 public:
  StatesCost(Eigen::Index rows, std::size_t states) {
    set_num_residuals(static_cast<int>(rows));
    mutable_parameter_block_sizes()->assign(states, ambient::kSize);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    std::vector<NavState> x;
    for (std::size_t i = 0; i < parameter_block_sizes().size(); ++i)
      x.push_back(from_parameters(parameters[i]));
    Eigen::VectorXd r;
    Eigen::MatrixXd J;
    evaluate(x, r, jacobians ? &J : nullptr);
    if (!r.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    for (std::size_t i = 0; jacobians && i < x.size(); ++i) {
      if (!jacobians[i]) continue;
      for (Eigen::Index first = 0; first < r.size(); first += kMaxResidual) {
        const Jacobian rows =
            J.block(first, static_cast<Eigen::Index>(i) * kStateDim,
                    std::min<Eigen::Index>(kMaxResidual, r.size() - first), kStateDim);
        to_ambient(x[i], rows, jacobians[i] + first * ambient::kSize);
      }
    }
    return true;
  }

 private:
  // J: in the charts at x, where it is not null.
  virtual void evaluate(const std::vector<NavState>& x, Eigen::VectorXd& r,
                        Eigen::MatrixXd* J) const = 0;
};

// Some rows of a factor.
class FactorCost final : public StatesCost {
 public:
  FactorCost(std::shared_ptr<const Factor> factor, std::vector<int> rows)
      : StatesCost(static_cast<Eigen::Index>(rows.size()), 2),
        factor_(std::move(factor)),
        rows_(std::move(rows)) {}

 private:
  void evaluate(const std::vector<NavState>& x, Eigen::VectorXd& r,
                Eigen::MatrixXd* J) const override {
    Residual all;
    Jacobian Ja, Jb;
    factor_->evaluate(x[0], x[1], all, J ? &Ja : nullptr, J ? &Jb : nullptr);
    r = all(rows_);
    if (!J) return;
    J->resize(num_residuals(), 2 * kStateDim);
    *J << Ja(rows_, Eigen::all), Jb(rows_, Eigen::all);
  }

  std::shared_ptr<const Factor> factor_;
  std::vector<int> rows_;
};

// The factor's own loss, which the problem must not delete.
class BorrowedLoss final : public ceres::LossFunction {
 public:
  explicit BorrowedLoss(std::shared_ptr<const Factor> factor) : factor_(std::move(factor)) {}
  void Evaluate(double squared_norm, double rho[3]) const override {
    factor_->loss()->Evaluate(squared_norm, rho);
    // Uses the loss as a weight only, as the elimination does; its second derivative is left out.
    rho[2] = std::min(rho[2], 0.0);
  }

 private:
  std::shared_ptr<const Factor> factor_;
};

// A multiple of the unit matrix, 2 x 2.
void set(double diagonal, double* jacobian) {
  Eigen::Map<Eigen::Matrix2d> J(jacobian);
  J = diagonal * Eigen::Matrix2d::Identity();
}

// 1/sqrt(white) (r - g), with r the residual of the fix by its whole variance. Parameters: two
// states, g, the antenna.
class FixCost final : public ceres::CostFunction {
 public:
  FixCost(FixFactor fix, double white) : fix_(std::move(fix)), weight_(1 / std::sqrt(white)) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {ambient::kSize, ambient::kSize, 2, 3};
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const NavState a = from_parameters(parameters[0]), b = from_parameters(parameters[1]);
    FixFactor::Jacobians J;
    const Eigen::Vector2d r =
        fix_.evaluate(a, b, Eigen::Vector3d::ConstMapType(parameters[3]), jacobians ? &J : nullptr);
    if (!r.allFinite()) return false;
    for (int i = 0; i < 2; ++i) residuals[i] = weight_ * (r[i] - parameters[2][i]);
    if (!jacobians) return true;
    if (jacobians[0]) to_ambient(a, weight_ * J.a, jacobians[0]);
    if (jacobians[1]) to_ambient(b, weight_ * J.b, jacobians[1]);
    if (jacobians[2]) set(-weight_, jacobians[2]);
    if (!jacobians[3]) return true;
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> by_antenna(jacobians[3]);
    by_antenna = weight_ * J.antenna;
    return true;
  }

 private:
  FixFactor fix_;
  double weight_;
};

// g of a fix goes on from that of the one before: weight (g - kept g_before).
class LastingErrorCost final : public ceres::SizedCostFunction<2, 2, 2> {
 public:
  LastingErrorCost(double weight, double kept) : weight_(weight), kept_(kept) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    for (int i = 0; i < 2; ++i)
      residuals[i] = weight_ * (parameters[1][i] - kept_ * parameters[0][i]);
    if (!jacobians) return true;
    if (jacobians[0]) set(-weight_ * kept_, jacobians[0]);
    if (jacobians[1]) set(weight_, jacobians[1]);
    return true;
  }

 private:
  double weight_, kept_;
};

// (way - counted) / sigma, of a wheel.
class CountedCost final : public StatesCost {
 public:
  CountedCost(const Batch::Way& counted, std::size_t states)
      : StatesCost(1, states), counted_(counted) {}

 private:
  void evaluate(const std::vector<NavState>& x, Eigen::VectorXd& r,
                Eigen::MatrixXd* J) const override {
    const RolledWay way = rolled_way(x.data(), x.size(), counted_.contact);
    r.setConstant(1, (way.reported_m - counted_.counted_m) / counted_.sigma_m);
    if (!J) return;
    J->resize(1, static_cast<Eigen::Index>(x.size()) * kStateDim);
    for (std::size_t i = 0; i < x.size(); ++i)
      J->middleCols<kStateDim>(static_cast<Eigen::Index>(i) * kStateDim) =
          way.d[i].transpose() / counted_.sigma_m;
  }

  Batch::Way counted_;
};

class PriorCost final : public StatesCost {
 public:
  explicit PriorCost(std::shared_ptr<const MarginalPrior> prior)
      : StatesCost(prior->A.rows(), prior->x0.size()), prior_(std::move(prior)) {}

 private:
  void evaluate(const std::vector<NavState>& x, Eigen::VectorXd& r,
                Eigen::MatrixXd* J) const override {
    prior_->evaluate(x.data(), r, J);
  }

  std::shared_ptr<const MarginalPrior> prior_;
};

}  // namespace

std::vector<ceres::ResidualBlockId> add_to(ceres::Problem& problem,
                                           const std::shared_ptr<const Factor>& factor, double* a,
                                           double* b, bool robust) {
  std::vector<ceres::ResidualBlockId> blocks;
  std::vector<int> quadratic;
  for (int i = 0; i < factor->dimension(); ++i) {
    const double threshold = factor->robust_threshold(i);
    if (robust && threshold > 0)
      blocks.push_back(problem.AddResidualBlock(new FactorCost(factor, {i}),
                                                new ceres::CauchyLoss(threshold), a, b));
    else
      quadratic.push_back(i);
  }
  if (!quadratic.empty()) {
    ceres::LossFunction* loss = robust && factor->loss() ? new BorrowedLoss(factor) : nullptr;
    blocks.push_back(
        problem.AddResidualBlock(new FactorCost(factor, std::move(quadratic)), loss, a, b));
  }
  return blocks;
}

void add_to(ceres::Problem& problem, const Batch::Fix& fix, const FixBlocks& blocks) {
  problem.AddResidualBlock(new FixCost(fix.place, fix.white), nullptr, blocks.a, blocks.b,
                           blocks.lasting, blocks.antenna);
  if (fix.white >= 1.0) {
    problem.SetParameterBlockConstant(blocks.lasting);
    return;
  }
  const double kept = blocks.lasting_before ? fix.kept : 0.0;
  const double weight = 1 / std::sqrt((1 - fix.white) * (1 - kept * kept));
  if (blocks.lasting_before)
    problem.AddResidualBlock(new LastingErrorCost(weight, kept), nullptr, blocks.lasting_before,
                             blocks.lasting);
  else
    problem.AddResidualBlock(
        new ceres::NormalPrior(weight * Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero()),
        nullptr, blocks.lasting);
}

void add_to(ceres::Problem& problem, const Batch::Antenna& prior, double* antenna) {
  problem.AddParameterBlock(antenna, 3);
  if (prior.place_sigma <= 0.0 || prior.delay_sigma <= 0.0) {
    problem.SetParameterBlockConstant(antenna);
    return;
  }
  const Eigen::Vector3d sigmas(prior.place_sigma, prior.place_sigma, prior.delay_sigma);
  const Eigen::Matrix3d weight = sigmas.cwiseInverse().asDiagonal();
  problem.AddResidualBlock(new ceres::NormalPrior(weight, Eigen::Vector3d::Zero()), nullptr,
                           antenna);
}

void add_to(ceres::Problem& problem, const Batch::Way& counted,
            const std::vector<double*>& states) {
  problem.AddResidualBlock(new CountedCost(counted, states.size()), nullptr, states);
}

ceres::ResidualBlockId add_to(ceres::Problem& problem, std::shared_ptr<const MarginalPrior> prior,
                              const std::vector<double*>& states) {
  return problem.AddResidualBlock(new PriorCost(std::move(prior)), nullptr, states);
}

}  // namespace gprodom
