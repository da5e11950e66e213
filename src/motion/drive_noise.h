// How well accelerations and wheel agree while the robot drives: noise that no standstill shows.
//
// Vibration is aliased into all bands, and its slow part, with the ground's tilt, passes for
// changes of speed. So the IMU's change of speed is held against the wheel's over a short and a
// long time: what grows with the time is the accelerations' noise, what does not is the wheel's.
#pragma once

#include <deque>
#include <vector>

#include "estimation/nav_state.h"
#include "estimation/state_estimator.h"
#include "motion/wheel_delay.h"

namespace gprodom {

class DriveNoise {
 public:
  explicit DriveNoise(double gravity_mps2) : gravity_(gravity_mps2) {}

  // Of each state interval in turn, with `at` the state that it begins with. Intervals of which the
  // wheel tells nothing, or that begin with another state, break the sequence.
  void add(const StateInput& input, const NavState& at);

  // m/s^2/sqrt(Hz), forwards and sideways (x and y of body); 0 where driving has not shown more
  // than the wheel's own noise would.
  double accel_density() const { return accel_density_[0]; }
  double sideways_density() const { return accel_density_[1]; }

  // Of the same, forwards, what half a second shows: without what comes slower, as tilt, flicker
  // and the slip of a wheel do. 0: not known yet, which takes half a minute of driving.
  double accel_density_of_half_second() const;

  // m, one standard deviation of the wheel's distance over one state interval; 0: not known yet.
  double increment_sigma() const { return increment_sigma_m_; }

  double wheel_delay_s() const { return delay_.delay_s(); }

 private:
  // Of the speed by the IMU, less that by the wheel, at state intervals: S(k + 2m) - 2 S(k + m) +
  // S(k), which is free of a constant bias and of a constant tilt.
  Eigen::Array2d variance(std::size_t m) const;
  void learn();

  static constexpr std::size_t kMost = 600;        // intervals kept: two minutes of driving
  static constexpr std::size_t kFewest = 50;       // squares that say something
  static constexpr std::size_t kHalfMinute = 300;  // intervals
  static constexpr double kSlowest = 0.05;         // m/s; below, the robot stands or nearly

  double gravity_;
  TimeNs end_ = 0;                                // of the last interval
  double last_wheel_m_ = 0;                       // its distance, true metres
  double last_v_ = 0, last_p_ = 0, last_dt_ = 0;  // what the IMU adds to speed and distance in it
  struct Run {
    std::deque<Eigen::Vector2d> drift_mps;  // S forwards and sideways, one a state interval
  };
  std::deque<Run> runs_;  // driven without a break, newest last
  std::size_t kept_ = 0;
  Eigen::Array2d accel_density_ = Eigen::Array2d::Zero();
  double accel_density_of_half_second_ = 0.0;
  double increment_sigma_m_ = 0.0;
  WheelDelay delay_;
};

}  // namespace gprodom
