#include "motion/wheel_delay.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace gprodom {

namespace {

// Half the span of a second difference, in intervals. A constant bias or tilt cancels in it, and it
// is so short that the IMU's error is smaller than the effect of a delay.
constexpr std::size_t kHalfSpan = 3;

constexpr double kForget = 1.0 / 600;  // share of the sums, per interval: two minutes of driving
// A delay is reported after kFewestSquares squares, if the sum of squares without the delay is
// kSignificantRatio times that with it. At a constant speed only the noises of wheel and IMU are
// compared. Then at most 0.2 % of two-minute drives pass both limits by chance (with 40 squares
// and 1.5 times: 29 %).
constexpr double kFewestSquares = 100;
constexpr double kSignificantRatio = 2.0;
// Noises are not alike. So less is enough if wheel and IMU have, with the delay, a correlation of
// more than kLeastAlike: then most of what is compared are changes of the robot's speed.
constexpr double kLeastAlike = 0.6;
constexpr double kEnoughIfAlike = 1.5;

}  // namespace

void WheelDelay::add(double by_imu_mps, double by_wheel_mps, double dt) {
  const Speeds last = speeds_.empty() ? Speeds{} : speeds_.back();
  speeds_.push_back({last.imu_mps + by_imu_mps, last.wheel_mps + by_wheel_mps});
  constexpr std::size_t kNeeded = 2 * kHalfSpan + kLags;
  if (speeds_.size() < kNeeded) return;
  while (speeds_.size() > kNeeded) speeds_.pop_front();
  const auto second_difference = [this](double Speeds::*speed, std::size_t newest) {
    return speeds_[newest].*speed - 2 * speeds_[newest - kHalfSpan].*speed +
           speeds_[newest - 2 * kHalfSpan].*speed;
  };
  const double by_wheel = second_difference(&Speeds::wheel_mps, kNeeded - 1);
  for (std::size_t lag = 0; lag < kLags; ++lag) {
    const double by_imu = second_difference(&Speeds::imu_mps, kNeeded - 1 - lag);
    const double difference = by_wheel - by_imu;
    squares_[lag] += difference * difference - kForget * squares_[lag];
    products_[lag] += by_wheel * by_imu - kForget * products_[lag];
    if (lag == 0) imu_square_ += by_imu * by_imu - kForget * imu_square_;
  }
  wheel_square_ += by_wheel * by_wheel - kForget * wheel_square_;
  count_ += 1 - kForget * count_;
  dt_ = dt;
}

// Minimum of the parabola through the smallest sum and its neighbours. At the longest lag there is
// no parabola; the delay is then at least this lag.
double WheelDelay::delay_s() const {
  if (count_ < kFewestSquares) return 0.0;
  const auto least = std::min_element(squares_.begin(), squares_.end());
  const auto at = static_cast<std::size_t>(std::distance(squares_.begin(), least));
  const bool alike = products_[at] > kLeastAlike * std::sqrt(wheel_square_ * imu_square_);
  if (squares_.front() < (alike ? kEnoughIfAlike : kSignificantRatio) * *least) return 0.0;
  const auto lag = static_cast<double>(at);
  if (least == squares_.begin() || std::next(least) == squares_.end()) return lag * dt_;
  const double before = *std::prev(least), after = *std::next(least);
  return (lag + 0.5 * (before - after) / (before - 2 * *least + after)) * dt_;
}

}  // namespace gprodom
