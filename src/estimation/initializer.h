// Gravity, gyro bias and noise from a standstill: the first state and its prior.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

struct Initialization {
  std::optional<InitialState> initial;
  std::string refusal;  // why not, where there is no initial state; an operator can act on it
};

// What the wheel said over the samples' time.
struct WheelAtStart {
  bool heard = false;
  double path_m = 0.0;                       // unsigned
  double begin_mps = 0.0, end_mps = 0.0;     // signed speeds at the two ends
  static constexpr double kSpeedOver = 0.5;  // s, that these are means over
};

// From a standstill. samples: IMU in body axes, in time order, the last initializer.duration
// seconds. A robot whose wheel shows no more than noise stands, however its engine shakes it, if
// the means of its IMU are steady; without a wheel the IMU must be quiet.
// The state stands at the last sample: position 0, yaw 0, roll and pitch from gravity.
Initialization initialize(const Config& config, const std::vector<ImuSample>& samples,
                          const WheelAtStart& wheel);

// On the move, over the same kind of samples: tilt from their mean force less what the wheel and
// the gyro explain, speed from the wheel, a gyro bias of zero as uncertain as a gyro's bias is. The
// solutions of the first seconds make the best of it.
Initialization initialize_moving(const Config& config, const std::vector<ImuSample>& samples,
                                 const WheelAtStart& wheel);

}  // namespace gprodom
