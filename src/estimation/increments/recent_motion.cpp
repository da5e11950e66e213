#include "estimation/increments/recent_motion.h"

#include <algorithm>

namespace gprodom {

Eigen::Vector3d angular_velocity(const MotionStep& step, const Eigen::Vector3d& gyro_bias) {
  if (!step.gap_turn) return step.angular_velocity;
  return gyro_bias + Eigen::Vector3d(0, 0, *step.gap_turn / step.dt);
}

bool imu_silent(const std::vector<MotionStep>& steps) {
  return std::any_of(steps.begin(), steps.end(), [](const MotionStep& s) { return s.bridged; });
}

void RecentMotion::forget_before(TimeNs time) {
  while (!stretches_.empty() && stretches_.front().time < time) stretches_.pop_front();
}

ImuPreintegration RecentMotion::since(TimeNs time, const ImuBiases& biases, TimeNs moment) const {
  const auto stretch = std::find_if(stretches_.begin(), stretches_.end(),
                                    [&](const Stretch& s) { return s.time == time; });
  if (stretch == stretches_.end()) return {ImuNoise{}, biases.gyro, biases.accel};
  ImuPreintegration imu(stretch->noise, biases.gyro, biases.accel);
  double left = to_seconds(moment - time);
  for (const MotionStep& step : stretch->steps) {
    if (left <= 0) break;
    imu.integrate(step.acceleration, angular_velocity(step, biases.gyro), std::min(step.dt, left));
    left -= step.dt;
  }
  return imu;
}

}  // namespace gprodom
