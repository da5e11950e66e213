#include "estimation/fixed_lag_smoother.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "estimation/kernels/so3.h"

namespace gprodom {

FixedLagSmoother::FixedLagSmoother(double lag_s, const SolverOptions& options, SolverKind kind,
                                   const NavState& first, MarginalPrior prior)
    : lag_s_(lag_s),
      window_{0, {first}, {}, std::move(prior), std::make_shared<Eigen::Vector3d>(0, 0, 0)},
      solver_(kind == SolverKind::kChain ? make_chain_solver(options)
                                         : make_ceres_solver(options)) {}

FixedLagSmoother::StateId FixedLagSmoother::add_state(const NavState& predicted) {
  if (predicted.time <= newest().time)
    throw std::invalid_argument("FixedLagSmoother: a state must be newer than the last");
  window_.states.push_back(predicted);
  return newest_id();
}

bool FixedLagSmoother::add_factor(StateId a, StateId b, std::shared_ptr<const Factor> factor) {
  if (a < oldest_id() || b > newest_id() || a >= b) return false;
  auto& links = window_.links;
  const auto place =
      std::upper_bound(links.begin(), links.end(), a,
                       [](StateId id, const Window::Link& link) { return id < link.a; });
  links.insert(place, {a, b, links_made_++, std::move(factor)});
  return true;
}

// The information on the newest state's heading and position cannot exceed that on the common
// heading and position of the whole window, which is the prior's.
bool FixedLagSmoother::claims_too_much() const {
  for (const Window::Link& link : window_.links)
    if (link.factor->measures_place()) return false;
  return gained(window_.prior.common_information(), equations_.newest_information());
}

// Far from the origin, a small rotation of one state against the next is a long displacement, and
// its second-order part is larger than wheel and IMU allow. So the problem is solved in a frame
// with its origin at the robot.
SolveSummary FixedLagSmoother::solve() {
  const std::vector<NavState> states = window_.states;
  const MarginalPrior prior = window_.prior;
  const Eigen::Vector3d here = newest().p_odom;
  shift_origin(window_, here);
  SolveSummary summary = solver_->solve(window_, equations_);
  if (summary.usable) {
    summary.unfounded = std::exchange(prior_gained_, false) || claims_too_much();
    StateMatrix to_odom = StateMatrix::Identity();
    to_odom.block<3, 3>(row::kP, row::kTheta) = so3::skew(here);
    newest_covariance_ = to_odom * equations_.newest_covariance() * to_odom.transpose();
  }
  shift_origin(window_, -here);
  if (!summary.usable) {
    window_.states = states;
    window_.prior = prior;
  }
  return summary;
}

// In the frame of the solve.
EstimatedWay FixedLagSmoother::way_between(StateId a, StateId b,
                                           const Eigen::Vector3d& contact) const {
  const Eigen::Vector3d here = newest().p_odom;
  std::vector<NavState> states(window_.states.begin() + static_cast<long>(window_.index(a)),
                               window_.states.begin() + static_cast<long>(window_.index(b) + 1));
  for (NavState& x : states) x.p_odom -= here;
  const RolledWay way = rolled_way(states.data(), states.size(), contact);
  // States may have been marginalised since the solve.
  std::vector<StateVector> d(equations_.states(), StateVector::Zero());
  const size_t first = d.size() - window_.states.size() + window_.index(a);
  std::copy(way.d.begin(), way.d.end(), d.begin() + static_cast<long>(first));
  const std::vector<StateVector> covariance = equations_.covariance_with(d);
  EstimatedWay result{way.reported_m, 0.0, covariance.back()};
  for (size_t i = 0; i < d.size(); ++i) result.variance += d[i].dot(covariance[i]);
  result.with_newest.segment<3>(row::kP) += here.cross(result.with_newest.segment<3>(row::kTheta));
  return result;
}

void FixedLagSmoother::marginalise(std::optional<TimeNs> keep_since) {
  const TimeNs by_lag = newest().time - from_seconds(lag_s_);
  const TimeNs horizon = std::min(by_lag, keep_since.value_or(by_lag));
  while (window_.states.size() > 1 && window_.states.front().time < horizon)
    prior_gained_ |= marginalise_oldest(window_);
}

}  // namespace gprodom
