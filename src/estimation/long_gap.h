// The robot's state while the IMU is silent for long. docs/estimation.md, "Gaps of the IMU".
#pragma once

#include "estimation/nav_state.h"
#include "estimation/state_estimator.h"
#include "gprodom/config.h"

namespace gprodom {

struct CarriedState {
  NavState state;
  StateMatrix covariance;  // chart of nav_state.h
};

// `from` carried over an interval: along the wheel or, without one, at the speed that it had, and
// turning as it did for the first two seconds. gap_s: since the IMU fell silent, to the interval's
// end. The robot is taken to stay on level ground, to turn at will, and to have any speed that the
// wheel does not tell.
CarriedState carry_on(const Config& config, const CarriedState& from, const StateInput& input,
                      double gap_s);

// `size` errors from `first` on become independent of all others, with a covariance of their own.
void replace(StateMatrix& covariance, int first, int size, const Eigen::MatrixXd& block);

// With sign 1: from the chart's position error to the plain one, p = p^ + dp. With -1: back.
StateMatrix plain_position(const NavState& x, double sign);

}  // namespace gprodom
