#include "pipeline/slip_watch.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

constexpr TimeNs kAway = 1'000'000'000;            // ns
constexpr double kFirstImpression = 3.0;           // standard deviations
constexpr TimeNs kBorneOut = 2'000'000'000;        // ns
constexpr double kAgrees = 2.0, kDisagrees = 3.0;  // standard deviations of the radar's distance

}  // namespace

SlipWatch::SlipWatch(const WheelConfig& config)
    : config_(config), window_(from_seconds(config.slip_window)) {}

void SlipWatch::add(const OdometryEstimate& estimate, const WheelHistory& wheel, TimeNs wheel_now) {
  if (!config_.enabled || config_.slip_threshold <= 0) return;
  const double speed = (estimate.v_body + estimate.omega_body.cross(config_.lever_arm)).x();
  if (!track_.empty() && estimate.time > track_.end() + window_) track_ = {};  // after a gap
  track_.advance(estimate.time, speed);
  track_.forget_before(estimate.time - kMemory);
  while (!slipped_.empty() && slipped_.front().to < estimate.time - kMemory) slipped_.pop_front();

  if (estimate.time > wheel_now + kAway) back_from_silence_ = true;
  const TimeNs to = std::min(wheel_now, estimate.time), from = to - window_;
  if (to <= judged_) return;
  judged_ = to;
  now_ = WheelSlip::kNone;
  const auto moved = distances(from, to, wheel, estimate.wheel_scale);
  if (!moved) {
    if (back_from_silence_) mark(from, to);
    return;
  }
  now_ = judge(estimate, *moved);
  if (now_ == WheelSlip::kNone)
    back_from_silence_ = false;
  else
    mark(from, to);
}

// A velocity error is one for the whole window. The wheel's errors are those of its factor.
WheelSlip SlipWatch::judge(const OdometryEstimate& estimate, const Distances& moved) const {
  const double seconds = to_seconds(window_);
  const double innovation = moved.wheel_m - moved.ground_m;
  const double variance = estimate.velocity_covariance(0, 0) * seconds * seconds +
                          std::pow(estimate.wheel_scale_sigma * moved.ground_m, 2) +
                          config_.noise * config_.noise * std::abs(moved.ground_m) +
                          2 * config_.noise_floor * config_.noise_floor;
  const double threshold = back_from_silence_ ? std::min(kFirstImpression, config_.slip_threshold)
                                              : config_.slip_threshold;
  if (innovation * innovation < threshold * threshold * variance) return WheelSlip::kNone;
  return innovation * moved.wheel_m > 0 ? WheelSlip::kFast : WheelSlip::kSlow;
}

std::optional<SlipWatch::Distances> SlipWatch::distances(TimeNs from, TimeNs to,
                                                         const WheelHistory& wheel,
                                                         double wheel_scale) const {
  const auto wheel_from = wheel.distance(from), wheel_to = wheel.distance(to);
  if (track_.empty() || from < track_.begin() || !wheel_from || !wheel_to) return std::nullopt;
  return Distances{(*wheel_to - *wheel_from) / wheel_scale, track_.path(to) - track_.path(from)};
}

void SlipWatch::hear(const Displacement& radar, const WheelHistory& wheel, double wheel_scale) {
  const bool slips =
      now_ != WheelSlip::kNone && !slipped_.empty() && slipped_.back().from <= radar.from;
  const auto moved = slips ? distances(radar.from, radar.to, wheel, wheel_scale) : std::nullopt;
  const auto off = [&](double m) {
    return std::abs(std::abs(m) - radar.distance_m) / radar.sigma_m;
  };
  if (!moved || off(moved->wheel_m) > kAgrees || off(moved->ground_m) < kDisagrees) {
    borne_out_ = {0, 0};
    return;
  }
  if (borne_out_.to < radar.from) borne_out_.from = radar.from;
  borne_out_.to = radar.to;
}

std::optional<WheelWord> SlipWatch::borne_out(TimeNs time, const WheelHistory& wheel,
                                              double wheel_scale) {
  if (borne_out_.to - borne_out_.from < kBorneOut) return std::nullopt;
  borne_out_ = {0, 0};  // now or never: a verdict that waits, as for a wheel gone silent, is stale
  if (slipped_.empty()) return std::nullopt;
  const auto slip =
      distances(std::max(slipped_.back().from, track_.begin()), time, wheel, wheel_scale);
  const auto last = distances(time - window_, time, wheel, wheel_scale);
  if (!slip || !last) return std::nullopt;
  slipped_.clear();
  now_ = WheelSlip::kNone;
  return WheelWord{last->wheel_m / to_seconds(window_), slip->wheel_m - slip->ground_m};
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
