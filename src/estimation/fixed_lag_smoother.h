// Least squares over the states of the last seconds. Older states live on as a marginal prior.
//
// States form a chain, and a factor reaches back a few states at most, so the normal equations are
// block-banded. One elimination from the oldest state to the newest (block Cholesky) gives the step
// and the newest state's covariance; a general sparse solver is not needed. docs/estimation.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "estimation/factors.h"
#include "estimation/marginal_prior.h"
#include "estimation/nav_state.h"

namespace gprodom {

struct SmootherOptions {
  double lag_s = 3.0;
  int max_iterations = 4;
  double convergence = 1e-3;  // stop once a step is expected to lower the cost by less
};

struct SolveSummary {
  bool usable = false;  // false: the states are those before the solve
  int steps = 0;        // tried
  int accepted = 0;
  double cost = 0.0;  // half the sum of squared (robust) residuals
  // The covariance claims to know place or heading better than the prior did. No factor measures
  // them, so this is a fault of the solver or of a factor.
  bool unfounded = false;
};

class FixedLagSmoother {
 public:
  // States are numbered from 0 in the order they are added, for good.
  using StateId = std::int64_t;

  FixedLagSmoother(const SmootherOptions& options, const NavState& first, MarginalPrior prior);

  StateId add_state(const NavState& predicted);  // time must grow; std::invalid_argument else

  // Ties a < b. false, and nothing is added, where one of them has left the window.
  bool add_factor(StateId a, StateId b, std::shared_ptr<const Factor> factor);

  // Gauss-Newton with damping where a step fails to lower the cost.
  SolveSummary solve();

  // Turns states older than the lag into the prior.
  void marginalise();

  StateId oldest_id() const { return first_id_; }
  StateId newest_id() const { return first_id_ + static_cast<StateId>(states_.size()) - 1; }
  const NavState& state(StateId id) const { return states_[static_cast<size_t>(id - first_id_)]; }
  const NavState& newest() const { return states_.back(); }
  const MarginalPrior& prior() const { return prior_; }

  // Of the newest state, in the chart of nav_state.h, at the last solve.
  const StateMatrix& newest_covariance() const { return newest_covariance_; }

 private:
  struct Link {
    StateId a, b;
    std::shared_ptr<const Factor> factor;
  };
  using States = std::vector<NavState>;

  // Of heading and position (x, y, z) of the whole window, 1/rad^2 and 1/m^2.
  static Eigen::Vector4d common_information(const MarginalPrior& prior);
  bool claims_too_much() const;
  void shift_origin(const Eigen::Vector3d& by);
  SolveSummary solve_at_origin();
  double cost(const States& x) const;
  double linearise(const States& x);  // fills H_ and g_ in units of their own, returns the cost
  bool eliminate(double damping);     // H_ -> L_; false where not positive definite
  double solve_step(std::vector<StateVector>& step) const;  // returns the expected decrease
  size_t index(StateId id) const { return static_cast<size_t>(id - first_id_); }
  StateMatrix& block(std::vector<StateMatrix>& m, size_t row, size_t column) const {
    return m[row * (bandwidth_ + 1) + (row - column)];
  }
  const StateMatrix& block(const std::vector<StateMatrix>& m, size_t row, size_t column) const {
    return m[row * (bandwidth_ + 1) + (row - column)];
  }

  SmootherOptions options_;
  StateId first_id_ = 0;
  States states_;
  std::vector<Link> links_;  // ordered by a
  MarginalPrior prior_;
  bool prior_gained_ = false;  // by marginalising
  StateMatrix newest_covariance_ = StateMatrix::Zero();

  // Workspace, kept between solves. Of blocks on the diagonal only the lower triangle counts.
  size_t bandwidth_ = 1;
  std::vector<StateMatrix> H_,
      L_;                       // lower block band: row i holds columns i, i-1, ..., i-bandwidth
  std::vector<size_t> first_;   // per row the first column with a block: the envelope
  std::vector<StateVector> g_;  // gradient
};

}  // namespace gprodom
