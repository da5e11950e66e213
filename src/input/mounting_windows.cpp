#include "input/mounting_windows.h"

namespace gprodom {

namespace {

constexpr double kWindow_s = 0.5;

}  // namespace

bool MountingWindows::add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
                          const Eigen::Vector3d& gyro_bias) {
  if (imu_silent(steps)) {
    open_ = {};
    complete_.clear();
    wheel_m_ = wheel_m;
    return false;
  }
  for (const MotionStep& step : steps) {
    open_.seconds += step.dt;
    open_.force += step.acceleration * step.dt;
    open_.rate += (step.angular_velocity - gyro_bias) * step.dt;
  }
  if (open_.seconds < kWindow_s) return false;
  open_.force /= open_.seconds;
  open_.rate /= open_.seconds;
  open_.wheel = wheel_m && wheel_m_;
  if (open_.wheel) open_.speed = (*wheel_m - *wheel_m_) / open_.seconds;
  complete_.push_back(open_);
  open_ = {};
  wheel_m_ = wheel_m;
  return true;
}

void MountingWindows::forget_oldest(std::size_t count) {
  complete_.erase(complete_.begin(), complete_.begin() + static_cast<std::ptrdiff_t>(count));
}

MountingAccelerations accelerations(const MountingWindow& before, const MountingWindow& now,
                                    const MountingWindow& after) {
  const double apart = 0.5 * (before.seconds + after.seconds) + now.seconds;
  return {{(after.speed - before.speed) / apart, now.speed * now.rate.z()}, now.force.head<2>()};
}

}  // namespace gprodom
