#include "pipeline/slip_watch.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

constexpr TimeNs kKept = 3'000'000'000;  // of track and slip, ns: beyond the reorder window

}  // namespace

SlipWatch::SlipWatch(const WheelConfig& config)
    : config_(config), window_(from_seconds(config.slip_window)) {}

void SlipWatch::add(const OdometryEstimate& estimate, const WheelHistory& wheel, TimeNs wheel_now) {
  if (!config_.enabled || config_.slip_threshold <= 0) return;
  const double speed = (estimate.v_body + estimate.omega_body.cross(config_.lever_arm)).x();
  if (!track_.empty() && estimate.time > track_.end() + window_) track_ = {};  // after a gap
  track_.advance(estimate.time, speed);
  track_.forget_before(estimate.time - kKept);
  while (!slipped_.empty() && slipped_.front().to < estimate.time - kKept) slipped_.pop_front();

  const TimeNs to = std::min(wheel_now, estimate.time), from = to - window_;
  if (to <= judged_) return;
  judged_ = to;
  now_ = WheelSlip::kNone;
  const auto wheel_from = wheel.distance(from), wheel_to = wheel.distance(to);
  if (from < track_.begin() || !wheel_from || !wheel_to) return;
  now_ = judge(estimate, *wheel_to - *wheel_from, track_.path(to) - track_.path(from));
  if (now_ != WheelSlip::kNone) mark(from, to);
}

// A velocity error is one for the whole window. The wheel's errors are those of its factor.
WheelSlip SlipWatch::judge(const OdometryEstimate& estimate, double wheel_m,
                           double ground_m) const {
  const double seconds = to_seconds(window_);
  const double innovation = wheel_m / estimate.wheel_scale - ground_m;
  const double variance = estimate.velocity_covariance(0, 0) * seconds * seconds +
                          std::pow(estimate.wheel_scale_sigma * ground_m, 2) +
                          config_.noise * config_.noise * std::abs(ground_m) +
                          2 * config_.noise_floor * config_.noise_floor;
  if (innovation * innovation < config_.slip_threshold * config_.slip_threshold * variance)
    return WheelSlip::kNone;
  return innovation * wheel_m > 0 ? WheelSlip::kFast : WheelSlip::kSlow;
}

void SlipWatch::mark(TimeNs from, TimeNs to) {
  if (!slipped_.empty() && from <= slipped_.back().to)
    slipped_.back().to = to;
  else
    slipped_.push_back({from, to});
}

bool SlipWatch::between(TimeNs from, TimeNs to) const {
  return std::any_of(slipped_.begin(), slipped_.end(),
                     [&](const Interval& s) { return s.from < to && s.to > from; });
}

}  // namespace gprodom
