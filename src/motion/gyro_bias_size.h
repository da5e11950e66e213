// How large may a gyro's bias be, before a standstill has shown it?
//
// While the robot drives, gravity shows how roll and pitch change, and so the bias of two axes. The
// bias about the vertical does not show. The axes of a gyro are made alike, so their biases are
// taken as draws of one normal distribution, whose size is estimated from the two.
// docs/estimation.md, "Start".
#pragma once

#include <vector>

#include "estimation/initializer.h"
#include "gprodom/types.h"

namespace gprodom {

struct GyroBiasSize {
  double sigma = kUsualGyroBias;  // rad/s, of each axis; kUsualGyroBias to kMaxGyroBias
  bool known = false;             // a bias of twice kUsualGyroBias would show
};

// samples: body axes, over the time of the wheel's speeds.
GyroBiasSize gyro_bias_size(const std::vector<ImuSample>& samples, const WheelSpeeds& wheel);

}  // namespace gprodom
