// The states of the last seconds, what ties them together, and what older ones left behind.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "estimation/factors.h"
#include "estimation/marginal_prior.h"
#include "estimation/nav_state.h"

namespace gprodom {

struct Window {
  // States are numbered from 0 in the order they are added, for good.
  using StateId = std::int64_t;
  struct Link {
    StateId a, b;
    std::int64_t number;  // of this link, grows with every new one
    std::shared_ptr<const Factor> factor;
  };

  StateId first_id = 0;
  std::vector<NavState> states;
  std::vector<Link> links;  // ordered by a
  MarginalPrior prior;      // holds the oldest states
  // Where the frame that the states are given in has its origin, in odom: zero but while the window
  // is solved. A factor that measures a place keeps it.
  std::shared_ptr<Eigen::Vector3d> origin = std::make_shared<Eigen::Vector3d>(0, 0, 0);

  size_t index(StateId id) const { return static_cast<size_t>(id - first_id); }
};

// Half the sum of squared (robust) residuals with the states at x.
double window_cost(const Window& window, const std::vector<NavState>& x);

// States and prior in a frame whose origin lies `by` further on.
void shift_origin(Window& window, const Eigen::Vector3d& by);

// Turns the oldest state, with what ties it, into the prior of those that it is tied to. Returns
// whether the prior knows more of place or heading then, with no factor that measured them.
bool marginalise_oldest(Window& window);

// Whether more is known than before, beyond rounding.
bool gained(const Eigen::Vector4d& before, const Eigen::Vector4d& now);

}  // namespace gprodom
