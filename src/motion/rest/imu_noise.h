// Noise of the IMU, measured from its own samples. Vibration raises it.
#pragma once

#include <vector>

#include "estimation/increments/imu_preintegration.h"
#include "gprodom/types.h"

namespace gprodom {

// Densities from second differences, which motion hardly changes. Zero if there are fewer than four
// samples.
ImuNoise measured_noise(const std::vector<ImuSample>& samples);

// With fewer samples the error of a density is more than 20 %.
constexpr std::size_t kEnoughForNoise = 20;

// For gyro and accelerometer: the measured density if it is clearly above the reference, otherwise
// the reference. The reference also if there are fewer than kEnoughForNoise samples.
ImuNoise prevailing_noise(const std::vector<ImuSample>& samples, const ImuNoise& reference);

}  // namespace gprodom
