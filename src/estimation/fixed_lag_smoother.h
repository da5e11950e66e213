// Fixed-lag smoother: least squares over the states of the last seconds, with a marginal prior for
// older ones.
#pragma once

#include <memory>
#include <optional>

#include "estimation/rolled_way.h"
#include "estimation/window_solver.h"
#include "gprodom/choices.h"

namespace gprodom {

class FixedLagSmoother {
 public:
  using StateId = Window::StateId;

  FixedLagSmoother(double lag_s, const SolverOptions& options, SolverKind kind,
                   const NavState& first, MarginalPrior prior);

  StateId add_state(const NavState& predicted);  // std::invalid_argument unless its time is newer

  // Adds a factor between states a < b. Returns false, and adds nothing, if one has left the
  // window.
  bool add_factor(StateId a, StateId b, std::shared_ptr<const Factor> factor);

  // If it fails, the states do not change.
  SolveSummary solve();

  // Marginalises the states older than the lag, but none from `keep_since` on: measurements that
  // are still to come refer to them.
  void marginalise(std::optional<TimeNs> keep_since = std::nullopt);

  StateId oldest_id() const { return window_.first_id; }
  StateId newest_id() const {
    return window_.first_id + static_cast<StateId>(window_.states.size()) - 1;
  }
  const NavState& state(StateId id) const { return window_.states[window_.index(id)]; }
  const NavState& newest() const { return window_.states.back(); }
  const MarginalPrior& prior() const { return window_.prior; }

  // For factors that measure a place: Window::origin.
  std::shared_ptr<const Eigen::Vector3d> origin() const { return window_.origin; }

  // Covariance of the newest state at the last solve, in the chart of nav_state.h.
  const StateMatrix& newest_covariance() const { return newest_covariance_; }

  // The way of a wheel through the states from a to b, as the last solve has left it. Call before
  // another state is added. contact: m, in body.
  EstimatedWay way_between(StateId a, StateId b, const Eigen::Vector3d& contact) const;

 private:
  bool claims_too_much() const;

  double lag_s_;
  Window window_;
  std::int64_t links_made_ = 0;
  std::unique_ptr<WindowSolver> solver_;
  NormalEquations equations_;
  bool prior_gained_ = false;  // by marginalising, since the last solve
  StateMatrix newest_covariance_ = StateMatrix::Zero();
};

}  // namespace gprodom
