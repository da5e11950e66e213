#include "motion/rest/imu_noise.h"

#include <cmath>

namespace gprodom {

ImuNoise measured_noise(const std::vector<ImuSample>& samples) {
  if (samples.size() < 4) return {};
  double gyro = 0, accel = 0;
  for (size_t i = 2; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 2], &b = samples[i - 1], &c = samples[i];
    gyro += (a.angular_velocity - 2 * b.angular_velocity + c.angular_velocity).squaredNorm();
    accel += (a.acceleration - 2 * b.acceleration + c.acceleration).squaredNorm();
  }
  // A second difference of white noise has 1 + 4 + 1 times its variance, here on three axes.
  const double n = 18.0 * static_cast<double>(samples.size() - 2);
  const double dt = to_seconds(samples.back().time - samples.front().time) /
                    static_cast<double>(samples.size() - 1);
  return {std::sqrt(gyro / n * dt), std::sqrt(accel / n * dt)};
}

ImuNoise prevailing_noise(const std::vector<ImuSample>& samples, const ImuNoise& reference) {
  constexpr double kSignificant = 1.2;  // 1 + three standard deviations with 80 samples
  if (samples.size() < kEnoughForNoise) return reference;
  const ImuNoise measured = measured_noise(samples);
  auto prevailing = [](double at_rest, double now) {
    return now > kSignificant * at_rest ? now : at_rest;
  };
  return {prevailing(reference.gyro_density, measured.gyro_density),
          prevailing(reference.accel_density, measured.accel_density)};
}

}  // namespace gprodom
