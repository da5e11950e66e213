#include "estimation/graph/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "estimation/graph/planar_factors.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;

namespace {

// A wheel's scale that is held still needs a finite weight: 0.1 ppm.
constexpr double kHeldScaleSigma = 1e-7;

// Steps that were joined are linear in their errors no further than this, rad.
constexpr double kLooseYawSigma = 0.1;

// The pose that a step leads to, in the frame of the one it starts from.
PlanarPose moved(const PlanarStep& step, double scale) {
  const Eigen::Vector3d change = step.d_scale * (scale - step.scale);
  return {step.measured.p + change.head<2>(), step.measured.yaw + change[2]};
}

Matrix3d whitening_of(const Matrix3d& covariance) {
  const Eigen::LLT<Matrix3d> llt(covariance);
  if (llt.info() != Eigen::Success) {
    throw std::invalid_argument("pose graph: a step's covariance is not positive definite");
  }
  return llt.matrixL().solve(Matrix3d::Identity());
}

// The graph as Ceres sees it: three parameters a node, then the scale.
class Problem {
 public:
  struct Scale {
    double initial, prior, prior_sigma;
  };
  Problem(const std::vector<PlanarPose>& initial, const Scale& scale,
          const PoseGraphOptions& options)
      : options_(options), scale_(scale.initial) {
    nodes_.reserve(initial.size());
    for (const PlanarPose& pose : initial) nodes_.push_back({pose.p.x(), pose.p.y(), pose.yaw});
    for (auto& node : nodes_) problem_.AddParameterBlock(node.data(), 3);
    problem_.AddParameterBlock(&scale_, 1);
    problem_.AddParameterBlock(map_.data(), 3);
    problem_.SetParameterBlockConstant(map_.data());
    problem_.SetParameterBlockConstant(nodes_.front().data());
    problem_.AddResidualBlock(
        new ScalePrior(scale.prior, std::max(scale.prior_sigma, kHeldScaleSigma)), nullptr,
        &scale_);
  }

  void add_step(std::size_t from, const PlanarStep& step, const Matrix3d& whitening) {
    problem_.AddResidualBlock(new PlanarStepFactor(step, whitening), nullptr, nodes_[from].data(),
                              nodes_[from + 1].data(), &scale_);
  }

  void add_revisit(const RevisitEdge& edge, bool robust) {
    const bool in_map = edge.memory == kInMap;
    if (in_map) problem_.SetParameterBlockVariable(nodes_.front().data());
    problem_.AddResidualBlock(new PlanarRevisitFactor(edge, options_.revisit_yaw_sigma),
                              robust ? new ceres::CauchyLoss(options_.robust_threshold) : nullptr,
                              in_map ? map_.data() : nodes_[edge.memory].data(),
                              nodes_[edge.query].data());
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = options_.max_iterations;
    // A chain is stiff step by step and soft as a whole: what Ceres starts with would damp the
    // whole.
    options.initial_trust_region_radius = 1e12;
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
  double scale() const { return scale_; }

  // Of the newest node and the scale, from the normal equations at the solution with all else
  // eliminated.
  Matrix4d newest_covariance() {
    ceres::Problem::EvaluateOptions options;
    for (auto& node : nodes_) {
      if (!problem_.IsParameterBlockConstant(node.data())) {
        options.parameter_blocks.push_back(node.data());
      }
    }
    options.parameter_blocks.push_back(&scale_);
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
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(crs.num_cols, 4);
    unit.bottomRows<4>().setIdentity();
    const Matrix4d covariance = factorised.solve(unit).bottomRows<4>();
    return 0.5 * (covariance + covariance.transpose());
  }

 private:
  PoseGraphOptions options_;
  std::vector<std::array<double, 3>> nodes_;
  std::array<double, 3> map_ = {0.0, 0.0, 0.0};  // as the node of places fixed in it
  double scale_;
  ceres::Problem problem_;  // points into the three above
};

}  // namespace

PlanarEstimate extend(const PlanarEstimate& from, const PlanarStep& step) {
  PlanarEstimate to{compose(from.pose, moved(step, from.scale)), from.scale, Matrix4d::Zero()};
  // The step is in the frame of the pose it starts from, whose yaw turns it.
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(from.pose.yaw).toRotationMatrix();
  Matrix4d F = Matrix4d::Identity();
  const Vector2d ahead = to.pose.p - from.pose.p;
  F(0, 2) = -ahead.y();
  F(1, 2) = ahead.x();
  F.topRightCorner<3, 1>() = turn * step.d_scale;
  to.covariance = F * from.covariance * F.transpose();
  to.covariance.topLeftCorner<3, 3>() += turn * step.covariance * turn.transpose();
  return to;
}

PlanarStep joined(const PlanarStep& first, const PlanarStep& second) {
  const PlanarPose middle = moved(first, second.scale);
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(middle.yaw).toRotationMatrix();
  const Vector2d ahead = turn.topLeftCorner<2, 2>() * second.measured.p;
  Matrix3d F = Matrix3d::Identity();
  F(0, 2) = -ahead.y();
  F(1, 2) = ahead.x();
  PlanarStep step;
  step.measured = compose(middle, second.measured);
  step.scale = second.scale;
  step.d_scale = F * first.d_scale + turn * second.d_scale;
  step.covariance =
      F * first.covariance * F.transpose() + turn * second.covariance * turn.transpose();
  if (step.covariance(2, 2) > kLooseYawSigma * kLooseYawSigma) {
    step.d_scale.setZero();
    step.covariance = Eigen::Vector3d(1e4, 1e4, 10).asDiagonal();  // m^2, rad^2: anywhere
  }
  return step;
}

PoseGraph::PoseGraph(const PlanarPose& first, const PoseGraphOptions& options)
    : options_(options), nodes_{first} {
  if (options.revisit_yaw_sigma <= 0) {
    throw std::invalid_argument("pose graph: a standard deviation must be above 0");
  }
}

std::size_t PoseGraph::add_node(const PlanarStep& step) {
  steps_.push_back({step, whitening_of(step.covariance)});
  nodes_.push_back(compose(nodes_.back(), moved(step, scale_.value_or(step.scale))));
  return nodes_.size() - 1;
}

void PoseGraph::add_revisit(const RevisitEdge& edge) {
  if ((edge.memory >= nodes_.size() && edge.memory != kInMap) || edge.query >= nodes_.size() ||
      edge.memory == edge.query) {
    throw std::invalid_argument("pose graph: a revisit needs two nodes that exist");
  }
  if (!(edge.sigma_m > 0) || !(edge.lateral_sigma_m > 0)) {
    throw std::invalid_argument("pose graph: a standard deviation must be above 0");
  }
  revisits_.push_back(edge);
}

void PoseGraph::keep_only(const std::vector<bool>& nodes) {
  if (nodes.size() != nodes_.size() || !nodes.front() || !nodes.back()) {
    throw std::invalid_argument("pose graph: the first and the newest node must stay");
  }
  std::vector<std::size_t> number(nodes.size());  // of those that stay
  std::size_t left = 0;
  std::optional<PlanarStep> way;  // from the last node that stays
  std::vector<Step> steps;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (i > 0) {
      const PlanarStep& step = steps_[i - 1].odometry;
      if (way || !nodes[i]) way = way ? joined(*way, step) : step;
      if (nodes[i]) {
        steps.push_back(way ? Step{*way, whitening_of(way->covariance)} : steps_[i - 1]);
        way.reset();
      }
    }
    if (!nodes[i]) continue;
    number[i] = left;
    nodes_[left++] = nodes_[i];
  }
  nodes_.resize(left);
  steps_ = std::move(steps);
  const auto goes = [&](const RevisitEdge& edge) {
    return !nodes[edge.query] || (edge.memory != kInMap && !nodes[edge.memory]);
  };
  revisits_.erase(std::remove_if(revisits_.begin(), revisits_.end(), goes), revisits_.end());
  for (RevisitEdge& edge : revisits_) {
    edge.query = number[edge.query];
    if (edge.memory != kInMap) edge.memory = number[edge.memory];
  }
}

void PoseGraph::move(const PlanarPose& in_map_of_before) {
  for (PlanarPose& node : nodes_) node = compose(in_map_of_before, node);
}

// Deviations of each revisit along the track, in a solution.
std::vector<double> PoseGraph::deviations(const std::vector<PlanarPose>& nodes) const {
  std::vector<double> result;
  for (const RevisitEdge& edge : revisits_) {
    const PlanarPose memory =
        edge.memory == kInMap ? edge.memory_at : compose(nodes[edge.memory], edge.memory_at);
    const PlanarPose query = compose(nodes[edge.query], edge.query_at);
    result.push_back(std::abs(between(memory, query).p.x() - edge.offset_m) / edge.sigma_m);
  }
  return result;
}

PoseGraphSolution PoseGraph::solve(double scale, double scale_sigma) {
  PoseGraphSolution solution;
  solution.trusted.assign(revisits_.size(), true);
  solution.nodes = nodes_;
  solution.newest.scale = scale_.value_or(scale);
  auto& trusted = solution.trusted;
  // A wrong revisit drags right ones with it: the worst go first, with a robust kernel, and what is
  // right then comes back. What is left is solved without a kernel.
  enum class Stage { kDrop, kRestore, kFinal };
  for (Stage stage = Stage::kDrop;;) {
    Problem problem(solution.nodes, {solution.newest.scale, scale, scale_sigma}, options_);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      problem.add_step(i, steps_[i].odometry, steps_[i].whitening);
    }
    for (std::size_t i = 0; i < revisits_.size(); ++i) {
      if (trusted[i]) problem.add_revisit(revisits_[i], stage != Stage::kFinal);
    }
    problem.solve();
    for (std::size_t i = 0; i < nodes_.size(); ++i) solution.nodes[i] = problem.node(i);
    solution.newest.scale = problem.scale();
    if (stage == Stage::kFinal) {
      solution.newest.pose = solution.nodes.back();
      if (nodes_.size() > 1) solution.newest.covariance = problem.newest_covariance();
      nodes_ = solution.nodes;
      scale_ = solution.newest.scale;
      return solution;
    }
    const std::vector<double> deviation = deviations(solution.nodes);
    double worst = 0;
    for (std::size_t i = 0; i < deviation.size(); ++i) {
      if (trusted[i]) worst = std::max(worst, deviation[i]);
    }
    const bool drop = worst > options_.drop_beyond;
    bool restored = false;
    for (std::size_t i = 0; i < deviation.size(); ++i) {
      if (drop && trusted[i] && deviation[i] > std::max(options_.drop_beyond, 0.5 * worst)) {
        trusted[i] = false;
      } else if (!drop && stage == Stage::kDrop && !trusted[i] &&
                 deviation[i] < options_.drop_beyond) {
        trusted[i] = restored = true;
      }
    }
    if (!drop) stage = restored ? Stage::kRestore : Stage::kFinal;
  }
}

}  // namespace gprodom
