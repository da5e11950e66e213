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

// samples: IMU in body axes, in time order, the last initializer.duration seconds.
// wheel_moved_m: how far the wheel turned meanwhile (0 where there is no wheel).
// The state stands at the last sample: position 0, yaw 0, roll and pitch from gravity.
Initialization initialize(const Config& config, const std::vector<ImuSample>& samples,
                          double wheel_moved_m);

}  // namespace gprodom
