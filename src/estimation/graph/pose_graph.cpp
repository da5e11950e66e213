#include "estimation/graph/pose_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/graph/graph_problem.h"
#include "estimation/graph/planar_factors.h"
#include "estimation/graph/wrong_revisits.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector2d;

namespace {

// rad; beyond this yaw error the linear combination of two steps is no longer valid.
constexpr double kLooseYawSigma = 0.1;

// The end of a step in the frame of its beginning.
PlanarPose moved(const PlanarStep& step, double scale, double slip) {
  const Eigen::Vector3d change = step.d_scale * (scale - step.scale);
  return {std::exp(slip) * step.measured.p + change.head<2>(), step.measured.yaw + change[2]};
}

PlanarPose place_at(const std::vector<PlanarPose>& nodes, const std::vector<double>& slips,
                    std::size_t node, const PlanarPose& at, const WheelWay& way) {
  if (node == kInMap) return at;
  const std::size_t step = way.step(node);
  return compose(nodes[node], step < slips.size() ? stretched(at, way, slips[step]) : at);
}

// Gauss-Markov prediction from the step before.
double predicted_slip(const PlanarStep& step, double before, const SlipModel& model) {
  return step.slip_sigma > 0 ? model.correlation(step.seconds) * before : 0.0;
}

// With slip as an error of this step alone, where it is not to be estimated.
Matrix3d with_slip(const PlanarStep& step) {
  Matrix3d covariance = step.covariance;
  covariance.topLeftCorner<2, 2>() +=
      step.slip_sigma * step.slip_sigma * step.measured.p * step.measured.p.transpose();
  return covariance;
}

Matrix3d whitening_of(const Matrix3d& covariance) {
  const Eigen::LLT<Matrix3d> llt(covariance);
  if (llt.info() != Eigen::Success) {
    throw std::invalid_argument("pose graph: a covariance is not positive definite");
  }
  return llt.matrixL().solve(Matrix3d::Identity());
}

}  // namespace

PlanarEstimate extend(const PlanarEstimate& from, const PlanarStep& step, const SlipModel& model) {
  const double slip = predicted_slip(step, from.slip, model);
  PlanarEstimate to{compose(from.pose, moved(step, from.scale, slip)), from.scale, slip,
                    Matrix5d::Zero()};
  // The step is given in the frame of the pose where it begins.
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(from.pose.yaw).toRotationMatrix();
  // Gauss-Markov prediction of the slip to this step.
  const double kept = step.slip_sigma > 0 ? model.correlation(step.seconds) : 0.0;
  Matrix5d forget = Matrix5d::Identity();
  forget(4, 4) = kept;
  Matrix5d before = forget * from.covariance * forget;
  before(4, 4) += step.slip_sigma * step.slip_sigma * (1 - kept * kept);
  Matrix5d F = Matrix5d::Identity();
  F.topLeftCorner<3, 3>() = lever(to.pose.p - from.pose.p);
  F.block<3, 1>(0, 3) = turn * step.d_scale;
  F.block<2, 1>(0, 4) = turn.topLeftCorner<2, 2>() * (std::exp(slip) * step.measured.p);
  to.covariance = F * before * F.transpose();
  to.covariance.topLeftCorner<3, 3>() += turn * step.covariance * turn.transpose();
  return to;
}

PlanarStep joined(const PlanarStep& first, const PlanarStep& second) {
  const PlanarPose middle = moved(first, second.scale, 0.0);
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(middle.yaw).toRotationMatrix();
  const Matrix3d F = lever(turn.topLeftCorner<2, 2>() * second.measured.p);
  PlanarStep step;
  step.measured = compose(middle, second.measured);
  step.scale = second.scale;
  step.d_scale = F * first.d_scale + turn * second.d_scale;
  // Two steps have one slip, unless the distance of one was measured whatever the wheel did.
  const bool one_slip = (first.slip_sigma > 0) == (second.slip_sigma > 0);
  step.covariance = F * (one_slip ? first.covariance : with_slip(first)) * F.transpose() +
                    turn * (one_slip ? second.covariance : with_slip(second)) * turn.transpose();
  step.seconds = first.seconds + second.seconds;
  if (one_slip) step.slip_sigma = std::max(first.slip_sigma, second.slip_sigma);
  step.believed_slip_sigma = std::max(first.believed_slip_sigma, second.believed_slip_sigma);
  step.cut = first.cut || second.cut;
  if (step.covariance(2, 2) > kLooseYawSigma * kLooseYawSigma) {
    step.d_scale.setZero();
    step.covariance = Eigen::Vector3d(1e4, 1e4, 10).asDiagonal();  // m^2, rad^2: no information
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
  slips_.push_back(slips_.empty() ? 0.0 : predicted_slip(step, slips_.back(), options_.slip));
  nodes_.push_back(compose(nodes_.back(), moved(step, scale_.value_or(step.scale), slips_.back())));
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

void PoseGraph::set_fixes(std::vector<FixEdge> fixes) {
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const FixEdge& fix = fixes[i];
    if (fix.node >= nodes_.size() || fix.before.value_or(0) > i)
      throw std::invalid_argument(
          "pose graph: a fix needs a node, and a fix before it, that exist");
    if (Eigen::LLT<Eigen::Matrix2d>(fix.covariance).info() != Eigen::Success)
      throw std::invalid_argument("pose graph: a covariance is not positive definite");
  }
  fixes_ = std::move(fixes);
  lasting_.resize(fixes_.size(), Vector2d::Zero());
}

void PoseGraph::keep_only(const std::vector<bool>& nodes, const std::vector<bool>& cut) {
  if (nodes.size() != nodes_.size() || !nodes.front() || !nodes.back()) {
    throw std::invalid_argument("pose graph: the first and the newest node must stay");
  }
  std::vector<std::size_t> number(nodes.size());  // of those that stay
  std::size_t left = 0;
  std::optional<PlanarStep> way;     // from the last node that stays
  double slid_m = 0.0, way_m = 0.0;  // of this step: slip times length, and length
  std::vector<WhitenedStep> steps;
  std::vector<double> slips;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (i > 0) {
      PlanarStep step = steps_[i - 1].odometry;
      if (i < cut.size() && cut[i]) {
        step.cut = true;
        step.slip_sigma = 0.0;
      }
      if (way || !nodes[i]) way = way ? joined(*way, step) : step;
      way_m += step.measured.p.norm();
      slid_m += slips_[i - 1] * step.measured.p.norm();
      if (nodes[i]) {
        steps.push_back(way ? WhitenedStep{*way, whitening_of(way->covariance)}
                            : WhitenedStep{step, steps_[i - 1].whitening});
        const bool slips_at_all = steps.back().odometry.slip_sigma > 0;
        slips.push_back(slips_at_all && way_m > 0 ? slid_m / way_m : 0.0);
        way.reset();
        slid_m = way_m = 0.0;
      }
    }
    if (!nodes[i]) continue;
    number[i] = left;
    nodes_[left++] = nodes_[i];
  }
  nodes_.resize(left);
  steps_ = std::move(steps);
  slips_ = std::move(slips);
  const auto is_removed = [&](const RevisitEdge& edge) {
    return !nodes[edge.query] || (edge.memory != kInMap && !nodes[edge.memory]);
  };
  std::vector<bool> trusted;
  for (std::size_t i = 0; i < trusted_.size(); ++i) {
    if (!is_removed(revisits_[i])) trusted.push_back(trusted_[i]);
  }
  trusted_ = std::move(trusted);
  revisits_.erase(std::remove_if(revisits_.begin(), revisits_.end(), is_removed), revisits_.end());
  fixes_.clear();
  lasting_.clear();
  for (RevisitEdge& edge : revisits_) {
    edge.query = number[edge.query];
    if (edge.memory != kInMap) edge.memory = number[edge.memory];
  }
}

void PoseGraph::set_first_prior(const Matrix3d& covariance) {
  first_prior_ = FirstPrior{nodes_.front(), whitening_of(covariance)};
}

void PoseGraph::move(const PlanarPose& in_map_of_before) {
  first_prior_.reset();
  for (PlanarPose& node : nodes_) node = compose(in_map_of_before, node);
  for (RevisitEdge& edge : revisits_)
    if (edge.memory == kInMap) edge.memory_at = compose(in_map_of_before, edge.memory_at);
}

double PoseGraph::slip(std::size_t from) const {
  return slips_.empty() ? 0.0 : slips_[std::min(from, slips_.size() - 1)];
}

double PoseGraph::slip_sigma(std::size_t from) const {
  return steps_.empty() ? 0.0 : steps_[std::min(from, steps_.size() - 1)].odometry.slip_sigma;
}

PlanarPose PoseGraph::place(std::size_t node, const PlanarPose& at, const WheelWay& way) const {
  return place_at(nodes_, slips_, node, at, way);
}

PoseGraphSolution PoseGraph::solve(double scale, double scale_sigma) {
  GraphProblem problem(steps_, revisits_, fixes_, {{scale, scale_sigma}, first_prior_}, options_);
  GraphProblem::Unknowns at{nodes_, slips_, scale_.value_or(scale), lasting_};
  std::vector<bool> trusted = trusted_;
  trusted.resize(revisits_.size(), true);
  if (!fixes_.empty() || !refine(problem, trusted, options_, at))
    trusted = drop_wrong(problem, std::move(trusted), options_, at);
  predict_newest(trusted, at.scale, at.slips, at.nodes);
  PoseGraphSolution solution;
  if (nodes_.size() > 1) {
    solution.newest.slip = at.slips.back();
    solution.newest.covariance = problem.newest_covariance(trusted, at);
  }
  solution.work = problem.work();
  solution.newest.pose = at.nodes.back();
  solution.newest.scale = at.scale;
  solution.iterations = problem.iterations();
  trusted_ = trusted;
  solution.trusted = std::move(trusted);
  nodes_ = at.nodes;
  slips_ = std::move(at.slips);
  scale_ = at.scale;
  lasting_ = std::move(at.lasting);
  solution.nodes = std::move(at.nodes);
  return solution;
}

void PoseGraph::predict_newest(const std::vector<bool>& trusted, double scale,
                               std::vector<double>& slips, std::vector<PlanarPose>& nodes) const {
  std::size_t measured = 0;  // the newest node that a revisit or a fix ties
  for (std::size_t i = 0; i < trusted.size(); ++i)
    if (trusted[i]) measured = std::max(measured, revisits_[i].query);
  for (const FixEdge& fix : fixes_) measured = std::max(measured, fix.node);
  for (std::size_t i = measured; i < steps_.size(); ++i)
    if (steps_[i].odometry.cut) measured = i + 1;
  for (std::size_t i = measured + 1; i < steps_.size(); ++i) {
    const PlanarStep& step = steps_[i].odometry;
    slips[i] = predicted_slip(step, slips[i - 1], options_.slip);
    nodes[i + 1] = compose(nodes[i], moved(step, scale, slips[i]));
  }
}

std::optional<PoseGraph::NewestSolution> PoseGraph::solve_newest(std::size_t from,
                                                                 const Matrix3d& known) {
  if (!fixes_.empty()) return std::nullopt;
  PoseGraph part(nodes_[from], options_);
  std::vector<std::size_t> numbers;  // of its revisits
  for (std::size_t i = 0; i < revisits_.size(); ++i) {
    RevisitEdge edge = revisits_[i];
    if (edge.query <= from) continue;
    edge.query -= from;
    if (edge.memory != kInMap && edge.memory > from) {
      edge.memory -= from;
    } else {
      edge.memory_at = place_at(nodes_, slips_, edge.memory, edge.memory_at, edge.memory_way);
      edge.memory_way = {};
      edge.memory = kInMap;
    }
    part.revisits_.push_back(edge);
    numbers.push_back(i);
  }
  if (numbers.empty()) return std::nullopt;
  part.set_first_prior(known);
  const auto since = static_cast<std::ptrdiff_t>(from);
  part.nodes_.assign(nodes_.begin() + since, nodes_.end());
  part.steps_.assign(steps_.begin() + since, steps_.end());
  part.slips_.assign(slips_.begin() + since, slips_.end());
  part.scale_ = scale_;
  const PoseGraphSolution solution = part.solve(scale_.value_or(1.0), 0.0);
  std::copy(solution.nodes.begin() + 1, solution.nodes.end(), nodes_.begin() + since + 1);
  std::copy(part.slips_.begin(), part.slips_.end(), slips_.begin() + since);
  NewestSolution newest{solution.newest.pose, solution.newest.slip, {}, solution.work};
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (solution.trusted[i]) newest.trusted.push_back(numbers[i]);
  return newest;
}

}  // namespace gprodom
