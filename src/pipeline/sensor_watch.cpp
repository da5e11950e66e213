#include "pipeline/sensor_watch.h"

#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

constexpr int kSettled = 20;  // messages after which the usual interval counts
constexpr double kLearningRate = 0.05;
constexpr double kLonger = 1.6;      // times the usual interval, and
constexpr double kDeviations = 8.0;  // beyond it
constexpr double kUsuallyChanges = 0.9;
constexpr double kChangeRate = 1.0 / 200;  // per message
// Nearer to what the sensor said first, a value that stays is no limit of its range.
constexpr double kLeastAcceleration = 0.3, kLeastRate = 0.05;  // m/s^2, rad/s

}  // namespace

bool GapWatch::gap_before(TimeNs time) {
  const double dt = to_seconds(time - newest_);
  if (newest_ == 0) newest_ = time;
  if (dt <= 0 || newest_ == time) return false;
  newest_ = time;
  if (seen_ == 0) usual_s_ = dt;
  const bool gap =
      seen_ >= kSettled && dt > kLonger * usual_s_ && dt > usual_s_ + kDeviations * deviation_s_;
  ++seen_;
  // One gap must not pass for the usual.
  const double error = std::clamp(dt - usual_s_, -usual_s_, 0.5 * usual_s_);
  if (gap) return true;
  usual_s_ += kLearningRate * error;
  deviation_s_ += kLearningRate * (std::abs(error) - deviation_s_);
  return false;
}

bool StuckWatch::stuck(bool changed) {
  same_ = changed ? 0 : same_ + 1;
  if (same_ <= patience_) changing_ += kChangeRate * (changed - changing_);
  return same_ >= patience_ && changing_ > kUsuallyChanges;
}

std::string ImuWatch::check(const ImuSample& sample) {
  Values values;
  values << sample.acceleration, sample.angular_velocity;
  if (seen_ == 0) first_ = lowest_ = highest_ = last_ = values;
  ++seen_;
  lowest_ = lowest_.cwiseMin(values);
  highest_ = highest_.cwiseMax(values);
  const bool stuck = all_.stuck(values != last_);
  bool limited = false;
  for (int i = 0; i < 6; ++i) {
    const bool stays = axes_[static_cast<std::size_t>(i)].stuck(values[i] != last_[i]);
    const bool extreme = values[i] == lowest_[i] || values[i] == highest_[i];
    const double least = i < 3 ? kLeastAcceleration : kLeastRate;
    limited |= stays && extreme && std::abs(values[i] - first_[i]) > least;
  }
  last_ = values;
  if (stuck) return "values stuck";
  return limited ? "a value stays at the limit of its range" : "";
}

std::string TraceWatch::check(const GprTrace& trace) {
  const bool stuck = stuck_.stuck(trace.samples != last_);
  last_ = trace.samples;
  return stuck ? "values stuck" : "";
}

std::string TraceWatch::quality(const GprTrace& trace) {
  const auto quality = check_.check(trace.samples.data(), static_cast<int>(trace.samples.size()));
  dead_ = quality == gpr::TraceQuality::kDead;
  if (dead_) return "trace without a signal";
  return quality == gpr::TraceQuality::kSpiked ? "trace with a spike" : "";
}

}  // namespace gprodom
