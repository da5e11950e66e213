// Noise of the IMU as its own samples show it. Vibration raises it.
#pragma once

#include <vector>

#include "estimation/imu_preintegration.h"
#include "gprodom/types.h"

namespace gprodom {

// Densities from second differences, which motion hardly touches. Zero from fewer than four
// samples.
ImuNoise measured_noise(const std::vector<ImuSample>& samples);

// From fewer samples a density is not known to a fifth.
constexpr std::size_t kEnoughForNoise = 20;

// Of each sensor what the samples show where that is clearly more than the reference, else the
// reference; also where there are fewer than kEnoughForNoise.
ImuNoise prevailing_noise(const std::vector<ImuSample>& samples, const ImuNoise& reference);

}  // namespace gprodom
