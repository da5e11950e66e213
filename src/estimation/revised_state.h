// The robot's state once its gyro bias, or its speed, is found to be another. docs/estimation.md,
// "Steps of the gyro bias", "A slip taken back".
#pragma once

#include "estimation/long_gap.h"
#include "estimation/nav_state.h"

namespace gprodom {

// `from`, at a standstill, with the bias that its gyro shows there (rad/s, body). `known`: the last
// state whose bias a standstill bore out. Since then the bias may have moved at any time, and
// turned the heading unseen.
CarriedState with_gyro_bias(const CarriedState& from, const Eigen::Vector3d& gyro_bias,
                            const NavState& known);

// `from` with the speed and the place that the wheel or the radar gives it.
CarriedState with_speed_correction(const CarriedState& from, const SpeedCorrection& correction);

}  // namespace gprodom
