#include "motion/late_wheel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom {

namespace {

constexpr double kStep_s = 0.1;     // of the delay in use; a smaller error looks like no slip
constexpr double kLongest_s = 1.0;  // that is made up for

}  // namespace

bool LateWheel::follow(const StateInput& input) {
  intervals_.push_back({input.time, input.standing});
  while (intervals_.front().to <= input.time - from_seconds(kLongest_s)) intervals_.pop_front();
  const bool was_late = waits_ || delay_ > 0;
  if (!input.wheel_late || !was_late) {
    delay_ = 0;
    waits_ = input.wheel_late;
    return was_late || waits_;
  }
  const TimeNs delay = from_seconds(std::min(input.wheel_delay_s, kLongest_s));
  const bool differs = std::abs(to_seconds(delay - delay_)) > kStep_s;
  if ((!waits_ && !differs) || !stood(input.time - delay)) return false;
  delay_ = delay;
  waits_ = false;
  return true;
}

bool LateWheel::stood(TimeNs since) const {
  return std::all_of(intervals_.begin(), intervals_.end(),
                     [=](const Interval& each) { return each.to <= since || each.standing; });
}

StateInput LateWheel::earlier(const StateInput& input, TimeNs from, const ImuHistory& imu,
                              const WheelHistory& wheel) const {
  StateInput result = input;
  if (delay_ == 0) return result;
  const TimeNs to = input.time - delay_;
  result.steps = imu.steps(from - delay_, to);
  result.has_wheel = input.has_wheel && set_wheel_distances(result.steps, wheel, from, false);
  const auto then = std::find_if(intervals_.begin(), intervals_.end(),
                                 [=](const Interval& each) { return each.to >= to; });
  result.standing = then->standing;
  return result;
}

}  // namespace gprodom
