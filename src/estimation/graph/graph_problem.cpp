#include "estimation/graph/graph_problem.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "estimation/graph/planar_factors.h"
#include "estimation/graph/slip_factors.h"

namespace gprodom {
namespace {

// A fixed wheel scale needs a finite weight too: 0.1 ppm.
constexpr double kHeldScaleSigma = 1e-7;
// Cauchy threshold, standard deviations of the random walk: a larger change is a slip that begins
// or ends.
constexpr double kSlipBegins = 2.0;
constexpr double kLeastSeconds = 1e-3;  // s

}  // namespace

GraphProblem::GraphProblem(const std::vector<PlanarPose>& nodes,
                           const std::vector<WhitenedStep>& steps, const std::vector<double>& slips,
                           const Scale& scale, SlipPrior prior, const PoseGraphOptions& options)
    : options_(options), slips_(slips), scale_(scale.initial) {
  nodes_.reserve(nodes.size());
  for (const PlanarPose& pose : nodes) nodes_.push_back({pose.p.x(), pose.p.y(), pose.yaw});
  for (auto& node : nodes_) problem_.AddParameterBlock(node.data(), 3);
  problem_.AddParameterBlock(&scale_, 1);
  problem_.AddParameterBlock(map_.data(), 3);
  problem_.SetParameterBlockConstant(map_.data());
  for (double& none : no_slip_) {
    problem_.AddParameterBlock(&none, 1);
    problem_.SetParameterBlockConstant(&none);
  }
  problem_.SetParameterBlockConstant(nodes_.front().data());
  problem_.AddResidualBlock(
      new ScalePrior(scale.prior, std::max(scale.prior_sigma, kHeldScaleSigma)), nullptr, &scale_);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    problem_.AddResidualBlock(new PlanarStepFactor(steps[i].odometry, steps[i].whitening), nullptr,
                              nodes_[i].data(), nodes_[i + 1].data(), &scale_, &slips_[i]);
    if (steps[i].odometry.slip_sigma <= 0) problem_.SetParameterBlockConstant(&slips_[i]);
  }
  if (prior == SlipPrior::kGaussian)
    add_gaussian_slip_priors(steps);
  else
    add_slip_priors(steps);
}

void GraphProblem::add_slip_priors(const std::vector<WhitenedStep>& steps) {
  const SlipModel& model = options_.slip;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const PlanarStep& step = steps[i].odometry;
    if (step.slip_sigma <= 0) continue;
    const double seconds = std::max(step.seconds, kLeastSeconds);
    const double root = std::sqrt(seconds / model.lasts_s);
    const double witnessed = step.slip_sigma / model.sigma();
    const double none = std::hypot(model.surface * witnessed, step.believed_slip_sigma);
    const double size = model.size * witnessed;
    // The kernel's largest value: twice the log of the ratio of the densities that l has without
    // slip and with one. At least 1, where a slip is as likely as none.
    const double most = std::max(1.0, 2 * std::log((1 - model.share) / model.share * size / none));
    problem_.AddResidualBlock(new SlipFactor(root / none),
                              new WideGemanMcClureLoss(root * std::sqrt(most), width_), &slips_[i]);
    problem_.AddResidualBlock(new SlipFactor(root / size), nullptr, &slips_[i]);
    if (i == 0 || steps[i - 1].odometry.slip_sigma <= 0) continue;
    problem_.AddResidualBlock(
        new SlipChangeFactor(1.0, 1 / (model.change * witnessed * std::sqrt(seconds))),
        new WideCauchyLoss(kSlipBegins, width_), &slips_[i - 1], &slips_[i]);
  }
}

void GraphProblem::add_gaussian_slip_priors(const std::vector<WhitenedStep>& steps) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const PlanarStep& step = steps[i].odometry;
    if (step.slip_sigma <= 0) continue;
    if (i == 0 || steps[i - 1].odometry.slip_sigma <= 0) {
      problem_.AddResidualBlock(new SlipFactor(1 / step.slip_sigma), nullptr, &slips_[i]);
      continue;
    }
    const double kept = options_.slip.correlation(std::max(step.seconds, kLeastSeconds));
    problem_.AddResidualBlock(
        new SlipChangeFactor(kept, 1 / (step.slip_sigma * std::sqrt(1 - kept * kept))), nullptr,
        &slips_[i - 1], &slips_[i]);
  }
}

// nullptr if the place lies at the node or beyond the track.
double* GraphProblem::slip_of(std::size_t node, const WheelWay& way) {
  const std::size_t step = way.step(node);
  return way.p.isZero() || step >= slips_.size() ? nullptr : &slips_[step];
}

void GraphProblem::add_revisit(const RevisitEdge& edge, bool robust) {
  const bool in_map = edge.memory == kInMap;
  double* memory_slip = slip_of(edge.memory, edge.memory_way);
  double* query_slip = slip_of(edge.query, edge.query_way);
  // A Ceres residual must not have the same parameter twice. If both places lie on the same step,
  // the slip has hardly any effect between them.
  if (!memory_slip || memory_slip == query_slip) memory_slip = &no_slip_[0];
  if (!query_slip) query_slip = &no_slip_[1];
  if (in_map) problem_.SetParameterBlockVariable(nodes_.front().data());
  problem_.AddResidualBlock(
      new PlanarRevisitFactor(edge, options_.revisit_yaw_sigma),
      robust ? new WideCauchyLoss(options_.robust_threshold, width_) : nullptr,
      in_map ? map_.data() : nodes_[edge.memory].data(), nodes_[edge.query].data(), memory_slip,
      query_slip);
}

void GraphProblem::solve(double width) {
  width_ = width;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = options_.max_iterations;
  // Single steps of a chain are stiff, but the whole chain is soft. The default trust region would
  // damp the motion of the whole chain.
  options.initial_trust_region_radius = 1e12;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  if (!summary.IsSolutionUsable()) {
    throw std::runtime_error("pose graph: no solution: " + summary.message);
  }
}

PlanarPose GraphProblem::node(std::size_t i) const {
  return {{nodes_[i][0], nodes_[i][1]}, wrapped(nodes_[i][2])};
}

Matrix5d GraphProblem::newest_covariance() {
  ceres::Problem::EvaluateOptions options;
  const auto take = [&](double* block) {
    if (!problem_.IsParameterBlockConstant(block)) options.parameter_blocks.push_back(block);
  };
  // The parameters whose covariance is computed come last.
  const bool slips = !problem_.IsParameterBlockConstant(&slips_.back());
  for (std::size_t i = 0; i + 1 < slips_.size(); ++i) take(&slips_[i]);
  for (auto& node : nodes_) take(node.data());
  take(&scale_);
  take(&slips_.back());
  ceres::CRSMatrix crs;
  problem_.Evaluate(options, nullptr, nullptr, nullptr, &crs);
  using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const Eigen::Map<const Sparse> J(crs.num_rows, crs.num_cols, static_cast<int>(crs.values.size()),
                                   crs.rows.data(), crs.cols.data(), crs.values.data());
  const Eigen::SparseMatrix<double> normal = J.transpose() * J;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factorised(normal);
  if (factorised.info() != Eigen::Success) {
    throw std::runtime_error("pose graph: the normal equations are singular");
  }
  const int size = slips ? 5 : 4;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(crs.num_cols, size);
  unit.bottomRows(size).setIdentity();
  const Eigen::MatrixXd block = factorised.solve(unit).bottomRows(size);
  Matrix5d covariance = Matrix5d::Zero();
  covariance.topLeftCorner(size, size) = 0.5 * (block + block.transpose());
  return covariance;
}

}  // namespace gprodom
