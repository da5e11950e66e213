// The sliding window: the states of the last seconds, the factors between them, and the marginal
// prior of older states.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "estimation/factors.h"
#include "estimation/marginal_prior.h"
#include "estimation/nav_state.h"

namespace gprodom {

struct Window {
  // States are numbered from 0 in the order they are added; a number never changes.
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
  // The origin of the states' frame, in odom. It is zero except during a solve. A factor that
  // measures a position keeps a pointer to it.
  std::shared_ptr<Eigen::Vector3d> origin = std::make_shared<Eigen::Vector3d>(0, 0, 0);

  size_t index(StateId id) const { return static_cast<size_t>(id - first_id); }
};

// Half the sum of squared (robust) residuals.
double window_cost(const Window& window);

// Moves the origin of the frame of states and prior by `by`.
void shift_origin(Window& window, const Eigen::Vector3d& by);

// Marginalises the oldest state and its links: they become a prior on the states linked to it.
// Returns whether the prior has gained information on position or heading although no factor
// measured them.
bool marginalise_oldest(Window& window);

// Whether the information has grown by more than rounding.
bool gained(const Eigen::Vector4d& before, const Eigen::Vector4d& now);

}  // namespace gprodom
