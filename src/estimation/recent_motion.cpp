#include "estimation/recent_motion.h"

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

ImuPreintegration RecentMotion::since(const NavState& state, TimeNs moment) const {
  const auto stretch = std::find_if(stretches_.begin(), stretches_.end(),
                                    [&](const Stretch& s) { return s.time == state.time; });
  if (stretch == stretches_.end()) return {ImuNoise{}, state.gyro_bias, state.accel_bias};
  ImuPreintegration imu(stretch->noise, state.gyro_bias, state.accel_bias);
  double left = to_seconds(moment - state.time);
  for (const MotionStep& step : stretch->steps) {
    if (left <= 0) break;
    imu.integrate(step.acceleration, angular_velocity(step, state.gyro_bias),
                  std::min(step.dt, left));
    left -= step.dt;
  }
  return imu;
}

}  // namespace gprodom
