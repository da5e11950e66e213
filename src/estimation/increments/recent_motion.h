// The measurements of IMU and wheel since each state of the window.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "estimation/increments/imu_preintegration.h"
#include "gprodom/types.h"

namespace gprodom {

// IMU and wheel over a step of constant rate and force; body axes.
struct MotionStep {
  double dt = 0.0;  // s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  double wheel_m = 0.0;   // signed
  bool bridged = false;   // no IMU data: values interpolated, noise increased
  bool long_gap = false;  // part of a gap longer than kLongestBridge
  // Turn about body z (rad), only in a long gap: by left and right wheels, or as the robot turns
  // otherwise.
  std::optional<double> gap_turn;
};

// Turn rate in body (rad/s) of the gyro or, in a long gap, by gap_turn. The gyro's bias is added
// to the latter, so that both can be treated alike.
Eigen::Vector3d angular_velocity(const MotionStep& step, const Eigen::Vector3d& gyro_bias);

// Whether the IMU was silent in any of the steps.
bool imu_silent(const std::vector<MotionStep>& steps);

class RecentMotion {
 public:
  // Adds the steps that follow a state at `time`.
  void add(TimeNs time, const ImuNoise& noise, std::vector<MotionStep> steps) {
    stretches_.push_back({time, noise, std::move(steps)});
  }
  void forget_before(TimeNs time);
  void clear() { stretches_.clear(); }

  // Preintegrates from the state at `time` to a moment before the next state.
  struct ImuBiases {
    Eigen::Vector3d gyro, accel;  // rad/s, m/s^2
  };
  ImuPreintegration since(TimeNs time, const ImuBiases& biases, TimeNs moment) const;

 private:
  struct Stretch {
    TimeNs time;
    ImuNoise noise;
    std::vector<MotionStep> steps;
  };
  std::deque<Stretch> stretches_;
};

}  // namespace gprodom
