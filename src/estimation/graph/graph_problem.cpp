#include "estimation/graph/graph_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "estimation/graph/planar_factors.h"

namespace gprodom {
namespace {

// A fixed wheel scale needs a finite weight too: 0.1 ppm.
constexpr double kHeldScaleSigma = 1e-7;
constexpr double kHeld = 1e18;  // weight of what is held
// Weight of a node after a cut, so that the equations stay regular if its revisits are left out:
// that of a position known to 100 m.
constexpr double kAfterCut = 1e-4;
// Cauchy threshold, standard deviations of the random walk: a larger change is a slip that begins
// or ends.
constexpr double kSlipBegins = 2.0;
constexpr double kLeastSeconds = 1e-3;  // s
// A step that reduces the cost by less than this is the last one. No unknown, and no function of
// them, is then moved by more than 5 % of its standard deviation.
constexpr double kLeastGain = 1e-3;
constexpr double kLeastDamping = 1e-12, kFirstDamping = 1e-4, kMoreDamping = 10.0;

using One = Eigen::Matrix<double, 1, 1>;
using RowOfTwo = Eigen::Matrix<double, 1, 2>;

}  // namespace

GraphProblem::GraphProblem(const std::vector<WhitenedStep>& steps,
                           const std::vector<RevisitEdge>& revisits,
                           const std::vector<FixEdge>& fixes, const Priors& priors,
                           const PoseGraphOptions& options)
    : steps_(steps),
      revisits_(revisits),
      fixes_(fixes),
      priors_(priors),
      options_(options),
      equations_(4 * (steps.size() + 1) + 2 * fixes.size()) {
  priors_.scale.sigma = std::max(priors_.scale.sigma, kHeldScaleSigma);
  for (std::size_t i = 0; i < steps.size(); ++i) slip_terms_.push_back(slip_terms(i));
}

GraphProblem::SlipTerms GraphProblem::slip_terms(std::size_t i) const {
  SlipTerms terms;
  const PlanarStep& step = steps_[i].odometry;
  terms.possible = step.slip_sigma > 0;
  if (!terms.possible) return terms;
  terms.follows = i > 0 && steps_[i - 1].odometry.slip_sigma > 0;
  const SlipModel& model = options_.slip;
  const double seconds = std::max(step.seconds, kLeastSeconds);
  const double root = std::sqrt(seconds / model.lasts_s);
  const double witnessed = step.slip_sigma / model.sigma();
  const double none = std::hypot(model.surface * witnessed, step.believed_slip_sigma);
  const double size = model.size * witnessed;
  // The kernel's largest value: twice the log of the ratio of the densities that l has without
  // slip and with one. At least 1, where a slip is as likely as none.
  const double most = std::max(1.0, 2 * std::log((1 - model.share) / model.share * size / none));
  terms.none = root / none;
  terms.most = root * std::sqrt(most);
  terms.size = root / size;
  terms.change = 1 / (model.change * witnessed * std::sqrt(seconds));
  terms.kept = terms.follows ? model.correlation(seconds) : 0.0;
  terms.gaussian = 1 / (step.slip_sigma * std::sqrt(1 - terms.kept * terms.kept));
  return terms;
}

// weight l^2 for one slip, and weight (l_b - kept l_a)^2 for those of two steps in a row.
void GraphProblem::add_slip_prior(std::size_t i, const std::vector<double>& slips, double weight,
                                  double kept, double weight_of_change) {
  equations_.add<1, 1>({slip(i)}, One(1.0), One(slips[i]), weight);
  if (!slip_terms_[i].follows) return;
  const One change(slips[i] - kept * slips[i - 1]);
  equations_.add<1, 2>({slip(i - 1), slip(i)}, RowOfTwo(-kept, 1.0), change, weight_of_change);
}

double GraphProblem::add_slip_priors(SlipPrior prior, double width,
                                     const std::vector<double>& slips) {
  double cost = 0.0;
  for (std::size_t i = 0; i < slips.size(); ++i) {
    const SlipTerms& terms = slip_terms_[i];
    if (!terms.possible) {
      equations_.hold(slip(i), kHeld);
    } else if (prior == SlipPrior::kGaussian) {
      const double weight = terms.gaussian * terms.gaussian;
      add_slip_prior(i, slips, terms.follows ? 0.0 : weight, terms.kept, weight);
    } else {
      const double none = terms.none * slips[i], size = terms.size * slips[i];
      const Robust slipped = geman_mcclure(none * none, terms.most * width);
      const double change = terms.follows ? terms.change * (slips[i] - slips[i - 1]) : 0.0;
      const Robust began = cauchy(change * change, kSlipBegins * width);
      cost += slipped.cost + size * size + began.cost;
      add_slip_prior(i, slips, slipped.weight * terms.none * terms.none + terms.size * terms.size,
                     1.0, began.weight * terms.change * terms.change);
    }
  }
  return cost;
}

// The step on which a place lies; none (their number) if it lies at the node or beyond the track.
std::size_t GraphProblem::slip_step(std::size_t node, const WheelWay& way) const {
  return way.p.isZero() ? steps_.size() : std::min(way.step(node), steps_.size());
}

GraphProblem::RevisitAt GraphProblem::revisit_at(const RevisitEdge& edge,
                                                 const Unknowns& at) const {
  const std::size_t none = steps_.size(), query_step = slip_step(edge.query, edge.query_way);
  std::size_t memory_step = slip_step(edge.memory, edge.memory_way);
  // If both places lie on the same step, its slip has hardly any effect between them.
  if (memory_step == query_step) memory_step = none;
  const auto slip_at = [&](std::size_t step) { return step == none ? 0.0 : at.slips[step]; };
  const PlanarPose memory = edge.memory == kInMap ? PlanarPose() : at.nodes[edge.memory];
  return {revisit_residual(edge, options_.revisit_yaw_sigma, memory, at.nodes[edge.query],
                           slip_at(memory_step), slip_at(query_step)),
          memory_step, query_step};
}

std::vector<double> GraphProblem::deviations(const Unknowns& at) const {
  std::vector<double> result;
  result.reserve(revisits_.size());
  for (const RevisitEdge& edge : revisits_)
    result.push_back(revisit_at(edge, at).residual.value.norm());
  return result;
}

// Of the square of a residual.
Robust GraphProblem::kernel_of(double s, const Terms& terms) const {
  return terms.kernel == RevisitKernel::kRedescending
             ? cauchy(s, options_.robust_threshold * terms.width)
             : huber(s, options_.full_weight_below);
}

double GraphProblem::add_revisit(const RevisitEdge& edge, bool counts, const Terms& terms,
                                 const Unknowns& at) {
  const bool in_map = edge.memory == kInMap;
  const std::size_t none = steps_.size();
  const auto [residual, memory_step, query_step] = revisit_at(edge, at);
  const double s = residual.value.squaredNorm();
  const Robust kernel = kernel_of(s, terms);
  const int m = in_map ? kNoUnknown : node(edge.memory), q = node(edge.query);
  equations_.add<3, 8>({m, in_map ? m : m + 1, in_map ? m : m + 2, q, q + 1, q + 2,
                        memory_step == none ? kNoUnknown : slip(memory_step),
                        query_step == none ? kNoUnknown : slip(query_step)},
                       residual.J, residual.value, counts ? kernel.weight : 0.0);
  return counts ? kernel.cost : 0.0;
}

// Residuals of the white part: the error that the place shows, less the lasting one.
double GraphProblem::add_fix(std::size_t number, const Terms& terms, const Unknowns& at) {
  const FixEdge& fix = fixes_[number];
  const std::size_t none = steps_.size(), step = slip_step(fix.node, fix.way);
  const FixResidual found(fix, at.nodes[fix.node], step == none ? 0.0 : at.slips[step]);
  const double root = std::sqrt(fix.white);
  const Eigen::Vector2d white = (found.value - at.lasting[number]) / root;
  Eigen::Matrix<double, 2, 6> J;
  J << found.J / root, -Eigen::Matrix2d::Identity() / root;
  const double s = white.squaredNorm();
  const Robust kernel = kernel_of(s, terms);
  const int n = node(fix.node), error = lasting(number);
  equations_.add<2, 6>({n, n + 1, n + 2, step == none ? kNoUnknown : slip(step), error, error + 1},
                       J, white, kernel.weight);
  double cost = kernel.cost + add_lasting(number, at);
  if (fix.yaw_sigma > 0.0) {
    equations_.add<1, 1>({n + 2}, One(1 / fix.yaw_sigma), One(found.heading), 1.0);
    cost += found.heading * found.heading;
  }
  return cost;
}

// Prior of a lasting error: it goes on from the one before.
double GraphProblem::add_lasting(std::size_t number, const Unknowns& at) {
  const FixEdge& fix = fixes_[number];
  const int error = lasting(number);
  if (fix.white >= 1.0) {
    for (int k = 0; k < 2; ++k) equations_.hold(error + k, kHeld);
    return 0.0;
  }
  const double weight = 1 / ((1 - fix.white) * (1 - fix.kept * fix.kept));
  const Eigen::Vector2d change =
      at.lasting[number] -
      (fix.before ? fix.kept * at.lasting[*fix.before] : Eigen::Vector2d::Zero().eval());
  const int last = fix.before ? lasting(*fix.before) : kNoUnknown;
  for (int k = 0; k < 2; ++k)
    equations_.add<1, 2>({fix.before ? last + k : kNoUnknown, error + k}, RowOfTwo(-fix.kept, 1.0),
                         One(change[k]), weight);
  return weight * change.squaredNorm();
}

double GraphProblem::linearise(const Terms& terms, SlipPrior prior, const Unknowns& at) {
  equations_.clear();
  const One scale_error(at.scale - priors_.scale.scale);
  const double weight = 1 / (priors_.scale.sigma * priors_.scale.sigma);
  equations_.add<1, 1>({scale()}, One(1.0), scale_error, weight);
  double cost = weight * scale_error.squaredNorm();
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    if (steps_[i].odometry.cut) {
      for (int k = 0; k < 3; ++k) equations_.hold(node(i + 1) + k, kAfterCut);
      continue;
    }
    const PlanarResidual residual =
        step_residual(steps_[i], at.nodes[i], at.nodes[i + 1], at.scale, at.slips[i]);
    const int a = node(i), b = node(i + 1);
    equations_.add<3, 8>({a, a + 1, a + 2, b, b + 1, b + 2, scale(), slip(i)}, residual.J,
                         residual.value, 1.0);
    cost += residual.value.squaredNorm();
  }
  cost += add_slip_priors(prior, terms.width, at.slips);
  bool tied = false;
  for (std::size_t i = 0; i < revisits_.size(); ++i) {
    cost += add_revisit(revisits_[i], terms.trusted[i], terms, at);
    tied = tied || (terms.trusted[i] && revisits_[i].memory == kInMap);
  }
  for (std::size_t i = 0; i < fixes_.size(); ++i) cost += add_fix(i, terms, at);
  cost += add_first(tied, at.nodes.front());
  return 0.5 * cost;
}

// tied: a revisit ties the track to the map.
double GraphProblem::add_first(bool tied, const PlanarPose& at) {
  first_held_ = !priors_.first && !tied;
  for (int k = 0; k < 3; ++k) equations_.hold(node(0) + k, first_held_ ? kHeld : 0.0);
  if (!priors_.first) return 0.0;
  const Eigen::Vector3d residual = prior_residual(*priors_.first, at);
  equations_.add<3, 3>({node(0), node(0) + 1, node(0) + 2}, priors_.first->whitening, residual,
                       1.0);
  return residual.squaredNorm();
}

GraphProblem::Unknowns GraphProblem::moved(const Unknowns& from, const Eigen::VectorXd& by) const {
  Unknowns to = from;
  for (std::size_t i = first_held_ ? 1 : 0; i < to.nodes.size(); ++i) {
    to.nodes[i].p += by.segment<2>(node(i));
    to.nodes[i].yaw = wrapped(to.nodes[i].yaw + by[node(i) + 2]);
  }
  for (std::size_t i = 0; i < to.slips.size(); ++i) {
    if (slip_terms_[i].possible) to.slips[i] += by[slip(i)];
  }
  to.scale += by[scale()];
  for (std::size_t i = 0; i < to.lasting.size(); ++i) {
    if (fixes_[i].white < 1.0) to.lasting[i] += by.segment<2>(lasting(i));
  }
  return to;
}

void GraphProblem::solve(const Terms& terms, Unknowns& at) {
  double cost = linearise(terms, SlipPrior::kUsuallyNone, at), damping = 0.0;
  bool solved = false;
  for (int k = 0; k < options_.max_iterations; ++k) {
    ++iterations_;
    if (equations_.factorise(damping)) {
      const Eigen::VectorXd step = -equations_.solve(equations_.gradient());
      const double gain = -0.5 * step.dot(equations_.gradient());
      Unknowns trial = moved(at, step);
      if (gain < kLeastGain) {
        at = std::move(trial);
        return;
      }
      const double trial_cost = linearise(terms, SlipPrior::kUsuallyNone, trial);
      if (trial_cost < cost) {
        at = std::move(trial);
        cost = trial_cost;
        solved = true;
        damping = damping > kFirstDamping ? damping / kMoreDamping : 0.0;
        continue;
      }
      linearise(terms, SlipPrior::kUsuallyNone, at);
    }
    damping = std::max(kFirstDamping, kMoreDamping * damping);
  }
  if (!solved) throw std::runtime_error("pose graph: no solution");
}

Matrix5d GraphProblem::newest_covariance(const std::vector<bool>& trusted, const Unknowns& at) {
  linearise({trusted, RevisitKernel::kFullWeight, 1.0}, SlipPrior::kGaussian, at);
  // Where weights of steps and of what is hardly held lie far apart, rounding may need some
  // damping.
  double damping = 0.0;
  while (!equations_.factorise(damping)) {
    damping = std::max(kLeastDamping, 100 * damping);
    if (damping > kFirstDamping)
      throw std::runtime_error("pose graph: the normal equations are singular");
  }
  const int last = static_cast<int>(steps_.size());
  const std::array rows{node(last), node(last) + 1, node(last) + 2, scale(), slip(last - 1)};
  const int size = slip_terms_.back().possible ? 5 : 4;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(lasting(fixes_.size()), size);
  for (int k = 0; k < size; ++k) unit(rows[k], k) = 1.0;
  const Eigen::MatrixXd columns = equations_.solve(unit);
  Matrix5d covariance = Matrix5d::Zero();
  for (int i = 0; i < size; ++i) covariance.row(i).head(size) = columns.row(rows[i]);
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace gprodom
