#include "pipeline/standstill.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

using Eigen::Vector3d;

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

namespace {

bool imu_still(const StandstillConfig& c, const ImuNoise& reference, const Vector3d& gyro_bias,
               const std::vector<ImuSample>& samples) {
  if (samples.size() < 4) return false;
  const ImuNoise noise = measured_noise(samples);
  Vector3d mean = Vector3d::Zero();
  for (const auto& s : samples) mean += s.angular_velocity;
  mean = mean / static_cast<double>(samples.size()) - gyro_bias;
  // The mean rate of a robot that stands is within a few deviations of its noise.
  const double span = to_seconds(samples.back().time - samples.front().time);
  const double ratio = std::sqrt(c.imu_ratio);
  return noise.accel_density < ratio * reference.accel_density &&
         noise.gyro_density < ratio * reference.gyro_density &&
         mean.norm() < 6 * reference.gyro_density / std::sqrt(span);
}

}  // namespace

StandstillVerdict judge_standstill(const Config& config, const ImuNoise& reference,
                                   const Vector3d& gyro_bias, const ImuHistory& imu,
                                   const WheelHistory& wheel,
                                   const std::vector<Displacement>& radar_standing, TimeNs from,
                                   TimeNs to) {
  const StandstillConfig& c = config.standstill;
  if (!c.enabled || !imu_still(c, reference, gyro_bias, imu.between(from, to))) return {};
  const TimeNs margin = std::max<TimeNs>(0, (from_seconds(c.window) - (to - from)) / 2);
  const bool wheel_still = config.wheel.enabled && wheel.distance(to) &&
                           wheel.path(from - margin, to + margin) <= 2 * config.wheel.noise_floor;
  const bool radar_still =
      std::any_of(radar_standing.begin(), radar_standing.end(),
                  [&](const Displacement& d) { return d.from <= from && d.to >= to; });
  // Without the radar the IMU must be still for longer: a robot that glides evenly is, for moments.
  const bool long_still =
      imu_still(c, reference, gyro_bias, imu.between(from - margin, to + margin));
  return {radar_still || (wheel_still && long_still), radar_still && !wheel_still};
}

}  // namespace gprodom
