// How late the wheel is against the IMU.
//
// Some drivers hold a wheel's values, smooth them, or stamp them when they are sent. Such a wheel
// seems to slip wherever the speed changes, and its scale cannot be learnt from accelerations. The
// delay is the one at which changes of speed by IMU and wheel agree best.
#pragma once

#include <array>
#include <deque>

namespace gprodom {

class WheelDelay {
 public:
  // By how much the mean speed of a state interval differs from that of the last one, m/s, by the
  // IMU and by the wheel. dt: of the interval, s. In turn; interrupt() where an interval is
  // missing.
  void add(double by_imu_mps, double by_wheel_mps, double dt);
  void interrupt() { speeds_.clear(); }

  // s; 0 where none shows.
  double delay_s() const;

 private:
  static constexpr std::size_t kLags = 4;  // state intervals: 0 to 3

  struct Speeds {
    double imu_mps, wheel_mps;
  };
  std::deque<Speeds> speeds_;  // since the sequence began, each but for a constant
  // Of the second differences of the wheel's speed less those of the IMU's so many intervals
  // before.
  std::array<double, kLags> squares_{};
  double count_ = 0.0, dt_ = 0.0;
};

}  // namespace gprodom
