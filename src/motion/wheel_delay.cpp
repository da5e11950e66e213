#include "motion/wheel_delay.h"

#include <algorithm>
#include <iterator>

namespace gprodom {

namespace {

// Second differences over so many intervals, twice: free of a constant bias and tilt, and short
// enough that accelerations are known better than the wheel's delay changes them.
constexpr std::size_t kOver = 3;

constexpr double kForget = 1.0 / 600;  // of the sums, per interval: two minutes of driving
// A delay is told after so many squares, where those without it are so many times those with it.
// At a constant speed there are only the noises of wheel and IMU to compare. Over two minutes of
// those, chance passes both limits in 0.2 % of drives at most (40 squares and 1.5 times: 29 %).
constexpr double kFewest = 100;
constexpr double kSignificant = 2.0;

}  // namespace

void WheelDelay::add(double by_imu_mps, double by_wheel_mps, double dt) {
  const Speeds last = speeds_.empty() ? Speeds{} : speeds_.back();
  speeds_.push_back({last.imu_mps + by_imu_mps, last.wheel_mps + by_wheel_mps});
  constexpr std::size_t kNeeded = 2 * kOver + kLags;
  if (speeds_.size() < kNeeded) return;
  while (speeds_.size() > kNeeded) speeds_.pop_front();
  const auto second_difference = [this](double Speeds::*speed, std::size_t newest) {
    return speeds_[newest].*speed - 2 * speeds_[newest - kOver].*speed +
           speeds_[newest - 2 * kOver].*speed;
  };
  const double by_wheel = second_difference(&Speeds::wheel_mps, kNeeded - 1);
  for (std::size_t lag = 0; lag < kLags; ++lag) {
    const double apart = by_wheel - second_difference(&Speeds::imu_mps, kNeeded - 1 - lag);
    squares_[lag] += apart * apart - kForget * squares_[lag];
  }
  count_ += 1 - kForget * count_;
  dt_ = dt;
}

// The least of a parabola through the smallest sum and its neighbours. At the longest lag there is
// no parabola, and the delay is that at least.
double WheelDelay::delay_s() const {
  if (count_ < kFewest) return 0.0;
  const auto least = std::min_element(squares_.begin(), squares_.end());
  if (squares_.front() < kSignificant * *least) return 0.0;
  const auto lag = static_cast<double>(std::distance(squares_.begin(), least));
  if (least == squares_.begin() || std::next(least) == squares_.end()) return lag * dt_;
  const double before = *std::prev(least), after = *std::next(least);
  return (lag + 0.5 * (before - after) / (before - 2 * *least + after)) * dt_;
}

}  // namespace gprodom
