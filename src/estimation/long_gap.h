// The robot's state during a long gap of the IMU. docs/estimation.md, "Gaps of the IMU".
#pragma once

#include "estimation/nav_state.h"
#include "estimation/state_input.h"
#include "gprodom/config.h"

namespace gprodom {

struct CarriedState {
  NavState state;
  StateMatrix covariance;  // chart of nav_state.h
};

// Standard deviation of a robot's speed to either side, m/s, where nothing measures it.
constexpr double kSideways = 0.05;

// Propagates `from` over an interval without the IMU: by the wheel's distance or, without a wheel,
// at the last speed; turning as the steps say. gap_s: from the begin of the gap to the interval's
// end. The covariance assumes that the robot stays on level ground; without a wheel it may have any
// speed.
CarriedState carry_on(const Config& config, const CarriedState& from, const StateInput& input,
                      double gap_s);

// Replaces the covariance of `size` errors from `first` on, and makes them independent of the rest.
void replace(StateMatrix& covariance, int first, int size, const Eigen::MatrixXd& block);

// Jacobian from the chart's position error to the plain one, p = p^ + dp (sign 1), or back (-1).
StateMatrix plain_position(const NavState& x, double sign);

}  // namespace gprodom
