#include "motion/wheel_gap.h"

#include <cmath>
#include <utility>

namespace gprodom {
namespace {

// Before a drive has shown more, as of a robot indoors: m/s, and the pairs that this counts for.
constexpr double kChange = 0.3, kPairs = 5.0;
constexpr TimeNs kApart = 1'000'000'000, kJitters = 100'000'000;

// A gap of which the states are kept until the encoder's count is known.
constexpr TimeNs kLongestKept = 30'000'000'000;
// After a gap, until the wheel has shown the speed at its end.
constexpr TimeNs kSettles = 500'000'000;

}  // namespace

void WheelGap::complete(StateInput& input, TimeNs from, const WheelHistory& wheel,
                        const SlipModel& slip) {
  const auto begin = wheel.distance(from), end = wheel.distance(input.time);
  if (begin && end) learn((*end - *begin) / to_seconds(input.time - from), input.time);
  input.speed_change = speed_change();
  if (input.has_wheel)
    end_gap(from, wheel, slip);
  else if (!before_ && begin)
    before_ = Count{from, *begin};
  if (before_ && input.time - before_->at > kLongestKept) before_.reset();
  if (before_) input.keep_since = before_->at;
  if (!counted_) return;
  input.keep_since = counted_->from;
  if (!input.has_wheel || input.time - counted_->to >= kSettles)
    input.counted = std::exchange(counted_, std::nullopt);
}

void WheelGap::end_gap(TimeNs end, const WheelHistory& wheel, const SlipModel& slip) {
  const auto before = std::exchange(before_, std::nullopt);
  const auto distance = wheel.distance(end), count = wheel.reported(end);
  if (!before || !distance || !count || wheel.jumped_since(before->at)) return;
  const double seconds = to_seconds(end - before->at);
  counted_ = CountedWay{
      before->at, end, *distance - before->distance_m, *count, slip.probability_within(seconds),
      slip.size};
}

void WheelGap::learn(double speed, TimeNs to) {
  while (!recent_.empty() && recent_.front().to < to - kApart) recent_.pop_front();
  if (!recent_.empty() && recent_.front().to < to - kApart + kJitters) {
    square_ += std::pow(speed - recent_.front().mps, 2);
    pairs_ += 1;
  }
  recent_.push_back({to, speed});
}

double WheelGap::speed_change() const {
  if (pairs_ == 0.0) return 0.0;
  return std::sqrt((kPairs * kChange * kChange + square_) / (kPairs + pairs_));
}

}  // namespace gprodom
