// A robot that drives, an interval between states at a time, for tests of the estimator.
#pragma once

#include <cmath>

#include "estimation/state_estimator.h"
#include "support/noise.h"

namespace gprodom {

inline constexpr double kStateInterval = 0.2, kSampleInterval = 0.01;  // s
inline constexpr double kSpeed = 0.5, kTurn = 0.1;                     // m/s, rad/s
inline constexpr double kTurnVariance = 0.05;  // rad^2, of an interval without the IMU

struct Motion {
  double speed, turn;     // m/s, rad/s
  double bias = 0.0;      // rad/s, of the gyro about z
  bool silent = false;    // what the histories make of an IMU gap, the last values held
  bool standing = false;  // proven
  double push = 0.0;      // m/s^2, forwards
};

// One state interval.
inline StateInput interval(double from, const Motion& motion, Noise& noise) {
  StateInput input;
  input.time = from_seconds(from + kStateInterval);
  input.noise = {1.6e-4, 6e-4};
  input.has_wheel = true;
  input.standing = motion.standing;
  for (int i = 0; i < kStateInterval / kSampleInterval - 0.5; ++i) {
    MotionStep step;
    step.dt = kSampleInterval;
    step.acceleration = Eigen::Vector3d(motion.push, motion.speed * motion.turn, 9.80665);
    step.angular_velocity = Eigen::Vector3d(0, 0, motion.turn + motion.bias);
    noise.shake(step, 6e-3, 1.6e-3);
    step.wheel_m = motion.speed * kSampleInterval;
    step.bridged = step.long_gap = motion.silent;
    if (motion.silent) step.gap_turn = motion.turn * step.dt;
    input.steps.push_back(step);
  }
  if (motion.silent) input.turn_variance = kTurnVariance;
  return input;
}

// All of the first state is well known but, perhaps, the wheel's scale.
inline StateEstimator at_ten_seconds(double speed, double scale_sigma = 1e-3,
                                     const Eigen::Vector3d& accel_bias = Eigen::Vector3d::Zero()) {
  InitialState initial;
  initial.state.time = from_seconds(10.0);
  initial.state.v_odom.x() = speed;
  initial.state.accel_bias = accel_bias;
  initial.noise = {1.6e-4, 6e-4};
  StateMatrix covariance = 1e-6 * StateMatrix::Identity();
  covariance(row::kScale, row::kScale) = scale_sigma * scale_sigma;
  initial.prior = gaussian_prior(initial.state, covariance);
  return {Config{}, initial};
}

inline double sigma(const StateResult& result, int i) { return std::sqrt(result.covariance(i, i)); }

}  // namespace gprodom
