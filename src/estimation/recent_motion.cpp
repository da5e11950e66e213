#include "estimation/recent_motion.h"

#include <algorithm>

namespace gprodom {

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
    imu.integrate(step.acceleration, step.angular_velocity, std::min(step.dt, left));
    left -= step.dt;
  }
  return imu;
}

}  // namespace gprodom
