// What the IMU measured since each state of the window: how the robot moved between states.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "estimation/imu_preintegration.h"
#include "estimation/nav_state.h"
#include "gprodom/types.h"

namespace gprodom {

// IMU and wheel over a step of constant rate and force; body axes.
struct MotionStep {
  double dt = 0.0;  // s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  double wheel_m = 0.0;   // signed
  bool bridged = false;   // no IMU data: values held, noise opened up
  bool long_gap = false;  // of more than kLongestBridge
  // rad, about body z; in a long gap, where left and right wheels tell of it.
  std::optional<double> wheel_turn;
};

// rad/s, body: of the gyro or, in a long gap, of the wheels; the bias counts as the gyro's.
Eigen::Vector3d angular_velocity(const MotionStep& step, const Eigen::Vector3d& gyro_bias);

class RecentMotion {
 public:
  // `steps` lead on from a state at `time`.
  void add(TimeNs time, const ImuNoise& noise, std::vector<MotionStep> steps) {
    stretches_.push_back({time, noise, std::move(steps)});
  }
  void forget_before(TimeNs time);
  void clear() { stretches_.clear(); }

  // From a state to a moment before the next one.
  ImuPreintegration since(const NavState& state, TimeNs moment) const;

 private:
  struct Stretch {
    TimeNs time;
    ImuNoise noise;
    std::vector<MotionStep> steps;
  };
  std::deque<Stretch> stretches_;
};

}  // namespace gprodom
