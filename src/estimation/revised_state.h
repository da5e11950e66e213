// The robot's state once its gyro bias is found to have moved. docs/estimation.md, "Steps of the
// gyro bias".
#pragma once

#include "estimation/long_gap.h"
#include "gprodom/nav_state.h"

namespace gprodom {

// `from`, at a standstill, with the bias that its gyro shows there (rad/s, body). `known`: the last
// state whose bias a standstill bore out. Since then the bias may have moved at any time, and
// turned the heading unseen.
CarriedState with_gyro_bias(const CarriedState& from, const Eigen::Vector3d& gyro_bias,
                            const NavState& known);

// `from` with the speed and the place that the wheel gives it.
CarriedState with_wheel_word(const CarriedState& from, const WheelWord& word);

}  // namespace gprodom
