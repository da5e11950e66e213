// The robot's state after its gyro bias, its speed or the mounting of the IMU was found wrong.
// docs/estimation.md, "Steps of the gyro bias", "A slip taken back", "A mounting that is found".
#pragma once

#include "estimation/long_gap.h"
#include "estimation/nav_state.h"
#include "estimation/rolled_way.h"

namespace gprodom {

// Replaces the gyro bias of `from`, a state at a standstill, by the rate that the gyro shows there
// (rad/s, body). known: the last state whose bias a standstill has confirmed. The bias may have
// moved at any time since then, and the variance of the heading grows accordingly.
CarriedState with_gyro_bias(const CarriedState& from, const Eigen::Vector3d& gyro_bias,
                            const NavState& known);

// The same motion in body axes that are turned, new from old. The body's heading and velocity in
// odom stay, since the wheel has given them; gravity and the biases are those of the IMU.
CarriedState with_turned_axes(const CarriedState& from, const Eigen::Matrix3d& R_new_old);

// `from`, with the way of the wheel as counted over a gap of its messages.
CarriedState with_counted_way(const CarriedState& from, const EstimatedWay& way, double counted_m,
                              const CountWeight& weight);

// Replaces the speed and the position of `from` by those of the wheel or the radar.
CarriedState with_speed_correction(const CarriedState& from, const SpeedCorrection& correction);

}  // namespace gprodom
