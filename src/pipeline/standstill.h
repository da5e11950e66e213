// Does the robot stand? From IMU, wheel and what the radar said.
#pragma once

#include <vector>

#include "gprodom/config.h"
#include "gprodom/state_estimator.h"
#include "gprodom/types.h"
#include "pipeline/sensor_history.h"

namespace gprodom {

// The IMU's noise as its own samples show it: densities from second differences, which motion
// hardly touches. Vibration raises them.
ImuNoise measured_noise(const std::vector<ImuSample>& samples);

struct StandstillVerdict {
  bool standing = false;
  bool wheel_contradicted = false;  // it stands although the wheel turns
};

// Over [from, to], the interval between two states.
//  - The IMU is still: noise within imu_ratio of the reference, no turning beyond it.
//  - Either the wheel stands as well, or the radar saw standing ground over the whole interval.
// The wheel alone proves nothing.
StandstillVerdict judge_standstill(const Config& config, const ImuNoise& reference,
                                   const Eigen::Vector3d& gyro_bias, const ImuHistory& imu,
                                   const WheelHistory& wheel,
                                   const std::vector<Displacement>& radar_standing, TimeNs from,
                                   TimeNs to);

}  // namespace gprodom
