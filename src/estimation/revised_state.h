// The robot's state after its gyro bias or its speed was found wrong. docs/estimation.md, "Steps of
// the gyro bias", "A slip taken back".
#pragma once

#include "estimation/long_gap.h"
#include "estimation/nav_state.h"

namespace gprodom {

// Replaces the gyro bias of `from`, a state at a standstill, by the rate that the gyro shows there
// (rad/s, body). known: the last state whose bias a standstill has confirmed. The bias may have
// moved at any time since then, and the variance of the heading grows accordingly.
CarriedState with_gyro_bias(const CarriedState& from, const Eigen::Vector3d& gyro_bias,
                            const NavState& known);

// Replaces the speed and the position of `from` by those of the wheel or the radar.

}  // namespace gprodom
