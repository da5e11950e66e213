// Noise of accelerations and wheel while the robot drives, which no standstill shows.
//
// Vibration is aliased into all bands. Its slow part and the tilt of the ground look like changes
// of speed. So the IMU's change of speed is compared with the wheel's over short and over long
// times. The part that grows with the time is noise of the accelerations; the constant part is
// noise of the wheel.
#pragma once

#include <deque>
#include <vector>

#include "estimation/nav_state.h"
#include "estimation/state_input.h"
#include "motion/wheel_delay.h"

namespace gprodom {

class DriveNoise {
 public:
  // Call for each state interval in turn, with `at` the state at its beginning. An interval without
  // a usable wheel, or one that begins with another state, interrupts the sequence.
  void add(const StateInput& input, const NavState& at);

  // m/s^2/sqrt(Hz), forwards and sideways (x and y of body); 0 while the differences can be
  // explained by the wheel's own noise.
  double accel_density() const { return accel_density_[0]; }
  double sideways_density() const { return accel_density_[1]; }

  // The forward density over one second, without slower effects such as tilt, flicker noise and
  // slip, and without slip that changes all the time. 0 while it is not known, which takes a minute
  // of driving.
  double accel_density_of_one_second() const;

  // m, one standard deviation of the wheel's distance over one state interval; 0: not known yet.
  double increment_sigma() const { return increment_sigma_m_; }

  double wheel_delay_s() const { return delay_.delay_s(); }

 private:
  // The squares of S(k + 2m) - 2 S(k + m) + S(k), forwards and sideways, with S the speed by the
  // IMU less that by the wheel and k a state interval. A constant bias and a constant tilt cancel
  // in them.
  struct Squares {
    std::size_t m;
    std::vector<double> sorted[2];
  };
  // S forwards and sideways, one a state interval.
  using Drift = std::deque<Eigen::Vector2d>;

  void append(const Eigen::Vector2d& drift);
  void drop_oldest();
  static Eigen::Array2d square(const Drift& s, std::size_t k, std::size_t m);
  static Eigen::Array2d variance(const Squares& squares);
  void learn();

  static constexpr std::size_t kMost = 600;    // intervals kept: two minutes of driving
  static constexpr std::size_t kFewest = 50;   // squares needed
  static constexpr std::size_t kMinute = 300;  // intervals
  static constexpr double kSlowest = 0.05;     // m/s; below, the robot stands or nearly

  TimeNs end_ = 0;                                // of the last interval
  double last_wheel_m_ = 0;                       // its distance, true metres
  double last_v_ = 0, last_p_ = 0, last_dt_ = 0;  // change of speed and distance in it by the IMU
  std::deque<Drift> runs_;  // sequences without an interruption, newest last; m/s
  std::size_t kept_ = 0;
  // In state intervals: the first short, then 1 s and more at 5 states per second. Tilt and flicker
  // noise make an error grow faster than white noise does. What counts is its size after the
  // seconds within which speeds change.
  Squares spans_[4] = {{1, {}}, {5, {}}, {10, {}}, {25, {}}};
  Eigen::Array2d accel_density_ = Eigen::Array2d::Zero();
  double accel_density_of_one_second_ = 0.0;
  double increment_sigma_m_ = 0.0;
  WheelDelay delay_;
};

}  // namespace gprodom
