// Least squares over the states of the last seconds. Older states live on as a marginal prior.
#pragma once

#include <memory>

#include "estimation/window_solver.h"
#include "gprodom/choices.h"

namespace gprodom {

struct SmootherOptions {
  double lag_s = 3.0;
  SolverOptions solver;
  SolverKind kind = SolverKind::kCeres;
};

class FixedLagSmoother {
 public:
  using StateId = Window::StateId;

  FixedLagSmoother(const SmootherOptions& options, const NavState& first, MarginalPrior prior);

  StateId add_state(const NavState& predicted);  // time must grow; std::invalid_argument else

  // Ties a < b. false, and nothing is added, where one of them has left the window.
  bool add_factor(StateId a, StateId b, std::shared_ptr<const Factor> factor);

  // Where it fails the states are left as they are.
  SolveSummary solve();

  // Turns states older than the lag into the prior.
  void marginalise();

  StateId oldest_id() const { return window_.first_id; }
  StateId newest_id() const {
    return window_.first_id + static_cast<StateId>(window_.states.size()) - 1;
  }
  const NavState& state(StateId id) const { return window_.states[window_.index(id)]; }
  const NavState& newest() const { return window_.states.back(); }
  const MarginalPrior& prior() const { return window_.prior; }

  // For factors that measure a place: Window::origin.
  std::shared_ptr<const Eigen::Vector3d> origin() const { return window_.origin; }

  // Of the newest state, in the chart of nav_state.h, at the last solve.
  const StateMatrix& newest_covariance() const { return newest_covariance_; }

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
