// IMU and wheel over half a second, of which the mounting of the IMU is judged.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/increments/recent_motion.h"

namespace gprodom {

// Means over a half to a whole second.
struct MountingWindow {
  double seconds = 0.0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // m/s^2
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   // rad/s, less the bias
  double speed = 0.0;                               // m/s, by the wheel
  bool wheel = true;                                // it is known
};

// Of windows that follow each other. A silent IMU begins anew.
class MountingWindows {
 public:
  // An interval that follows the one before. steps: IMU in body axes. wheel_m: the wheel's distance
  // (signed) at its end; nothing where it is not known. Returns whether it completes a window.
  bool add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
           const Eigen::Vector3d& gyro_bias);

  // Complete ones, newest last.
  const std::vector<MountingWindow>& complete() const { return complete_; }
  void forget_oldest(std::size_t count);

 private:
  MountingWindow open_;
  std::optional<double> wheel_m_;  // at the open window's beginning
  std::vector<MountingWindow> complete_;
};

// Horizontal accelerations (forwards, left; m/s^2) in the middle one of three windows.
struct MountingAccelerations {
  Eigen::Vector2d by_wheel,
      by_imu;  // by wheel and gyro; with gravity, as far as the body is tilted
};
MountingAccelerations accelerations(const MountingWindow& before, const MountingWindow& now,
                                    const MountingWindow& after);

}  // namespace gprodom
