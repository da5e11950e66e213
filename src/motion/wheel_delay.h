// Measures the delay of the wheel against the IMU.
//
// Some drivers hold the wheel's values, smooth them, or stamp them only when they are sent. Such a
// wheel seems to slip whenever the speed changes, and its scale cannot be learnt from
// accelerations. The delay is the one at which the changes of speed by IMU and by wheel agree best.
#pragma once

#include <array>
#include <deque>

namespace gprodom {

class WheelDelay {
 public:
  // The mean speed of a state interval less that of the last one, m/s, by the IMU and by the wheel.
  // dt: of the interval, s. Call for each interval in turn, and interrupt() if one is missing.
  void add(double by_imu_mps, double by_wheel_mps, double dt);
  void interrupt() { speeds_.clear(); }

  // s; 0 if none is significant.
  double delay_s() const;

 private:
  static constexpr std::size_t kLags = 4;  // state intervals: 0 to 3

  struct Speeds {
    double imu_mps, wheel_mps;
  };
  std::deque<Speeds> speeds_;  // of the newest intervals; an offset is common to all
  // For each lag, in intervals: squared difference of the wheel's second difference and that of the
  // IMU's speed before the lag, and product of the two.
  std::array<double, kLags> squares_{}, products_{};
  double wheel_square_ = 0.0, imu_square_ = 0.0;  // of the second differences themselves
  double count_ = 0.0, dt_ = 0.0;
};

}  // namespace gprodom
