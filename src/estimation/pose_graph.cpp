#include "gprodom/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "estimation/planar_factors.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector2d;

PlanarPose between(const PlanarPose& a, const PlanarPose& b) {
  return {Eigen::Rotation2Dd(-a.yaw) * (b.p - a.p), wrapped(b.yaw - a.yaw)};
}

PlanarPose compose(const PlanarPose& a, const PlanarPose& b_in_a) {
  return {a.p + Eigen::Rotation2Dd(a.yaw) * b_in_a.p, wrapped(a.yaw + b_in_a.yaw)};
}

namespace {

// The graph as Ceres sees it: three parameters a node, then the scale error.
class Problem {
 public:
  Problem(const std::vector<PlanarPose>& initial, const PoseGraphOptions& options)
      : options_(options) {
    for (const PlanarPose& pose : initial) nodes_.push_back({pose.p.x(), pose.p.y(), pose.yaw});
    for (auto& node : nodes_) problem_.AddParameterBlock(node.data(), 3);
    problem_.AddParameterBlock(&scale_error_, 1);
    problem_.SetParameterBlockConstant(nodes_.front().data());
    problem_.AddResidualBlock(new ScalePrior(options.scale_sigma), nullptr, &scale_error_);
  }

  void add_step(std::size_t from, const PlanarPose& measured, const Matrix3d& whitening) {
    problem_.AddResidualBlock(new StepFactor(measured, whitening), nullptr, nodes_[from].data(),
                              nodes_[from + 1].data(), &scale_error_);
  }

  void add_revisit(const RevisitEdge& edge, bool robust) {
    problem_.AddResidualBlock(new RevisitFactor(edge, options_.revisit_yaw_sigma),
                              robust ? new ceres::CauchyLoss(options_.robust_threshold) : nullptr,
                              nodes_[edge.memory].data(), nodes_[edge.query].data());
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = options_.max_iterations;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) {
      throw std::runtime_error("pose graph: no solution: " + summary.message);
    }
  }

  PlanarPose node(std::size_t i) const {
    return {{nodes_[i][0], nodes_[i][1]}, wrapped(nodes_[i][2])};
  }
  double scale_error() const { return scale_error_; }

  // Of the newest node, from the normal equations at the solution with all else eliminated.
  Matrix3d newest_covariance() {
    ceres::Problem::EvaluateOptions options;
    for (std::size_t i = 1; i < nodes_.size(); ++i) {
      options.parameter_blocks.push_back(nodes_[i].data());
    }
    options.parameter_blocks.push_back(&scale_error_);
    ceres::CRSMatrix crs;
    problem_.Evaluate(options, nullptr, nullptr, nullptr, &crs);
    using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    const Eigen::Map<const Sparse> J(crs.num_rows, crs.num_cols,
                                     static_cast<int>(crs.values.size()), crs.rows.data(),
                                     crs.cols.data(), crs.values.data());
    const Eigen::SparseMatrix<double> normal = J.transpose() * J;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factorised(normal);
    if (factorised.info() != Eigen::Success) {
      throw std::runtime_error("pose graph: the normal equations are singular");
    }
    const int first = crs.num_cols - 4;  // the newest node, before the scale
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(crs.num_cols, 3);
    unit.middleRows<3>(first).setIdentity();
    const Matrix3d covariance = factorised.solve(unit).middleRows<3>(first);
    return 0.5 * (covariance + covariance.transpose());
  }

 private:
  PoseGraphOptions options_;
  std::vector<std::array<double, 3>> nodes_;
  double scale_error_ = 0.0;
  ceres::Problem problem_;  // points into the two above
};

}  // namespace

PoseGraph::PoseGraph(const PlanarPose& first, const PoseGraphOptions& options)
    : options_(options), initial_{first} {
  if (options.scale_sigma <= 0 || options.revisit_yaw_sigma <= 0) {
    throw std::invalid_argument("pose graph: a standard deviation must be above 0");
  }
}

std::size_t PoseGraph::add_node(const PlanarPose& step, const Matrix3d& covariance) {
  const Eigen::LLT<Matrix3d> llt(covariance);
  if (llt.info() != Eigen::Success) {
    throw std::invalid_argument("pose graph: a step's covariance is not positive definite");
  }
  steps_.push_back({step, llt.matrixL().solve(Matrix3d::Identity())});
  initial_.push_back(compose(initial_.back(), step));
  return initial_.size() - 1;
}

void PoseGraph::add_revisit(const RevisitEdge& edge) {
  if (edge.memory >= nodes() || edge.query >= nodes() || edge.memory == edge.query) {
    throw std::invalid_argument("pose graph: a revisit needs two nodes that exist");
  }
  if (!(edge.sigma_m > 0) || !(edge.lateral_sigma_m > 0)) {
    throw std::invalid_argument("pose graph: a standard deviation must be above 0");
  }
  revisits_.push_back(edge);
}

// Deviations of each revisit along the track, in a solution.
std::vector<double> PoseGraph::deviations(const std::vector<PlanarPose>& nodes) const {
  std::vector<double> result;
  for (const RevisitEdge& edge : revisits_) {
    const double along = between(nodes[edge.memory], nodes[edge.query]).p.x() - edge.offset_m;
    result.push_back(std::abs(along) / edge.sigma_m);
  }
  return result;
}

PoseGraphSolution PoseGraph::solve() const {
  PoseGraphSolution solution;
  solution.trusted.assign(revisits_.size(), true);
  solution.nodes = initial_;
  auto& trusted = solution.trusted;
  // A wrong revisit drags right ones with it: the worst go first, with a robust kernel, and what is
  // right then comes back. What is left is solved without a kernel.
  enum class Stage { kDrop, kRestore, kFinal };
  for (Stage stage = Stage::kDrop;;) {
    Problem problem(solution.nodes, options_);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      problem.add_step(i, steps_[i].measured, steps_[i].whitening);
    }
    for (std::size_t i = 0; i < revisits_.size(); ++i) {
      if (trusted[i]) problem.add_revisit(revisits_[i], stage != Stage::kFinal);
    }
    problem.solve();
    for (std::size_t i = 0; i < nodes(); ++i) solution.nodes[i] = problem.node(i);
    if (stage == Stage::kFinal) {
      solution.scale_error = problem.scale_error();
      if (nodes() > 1) solution.newest_covariance = problem.newest_covariance();
      return solution;
    }
    const std::vector<double> deviation = deviations(solution.nodes);
    double worst = 0;
    for (std::size_t i = 0; i < deviation.size(); ++i) {
      if (trusted[i]) worst = std::max(worst, deviation[i]);
    }
    const bool drop = worst > options_.drop_beyond;
    for (std::size_t i = 0; i < deviation.size(); ++i) {
      if (drop && trusted[i] && deviation[i] > std::max(options_.drop_beyond, 0.5 * worst)) {
        trusted[i] = false;
      } else if (!drop && stage == Stage::kDrop && deviation[i] < options_.drop_beyond) {
        trusted[i] = true;
      }
    }
    if (!drop) stage = stage == Stage::kDrop ? Stage::kRestore : Stage::kFinal;
  }
}

}  // namespace gprodom
