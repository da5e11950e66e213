#include "input/sensor_watch.h"

#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

constexpr int kSettled = 20;  // messages until the usual interval is known
constexpr double kLearningRate = 0.05;
constexpr double kLonger = 1.6;      // a gap is longer than this times the usual interval,
constexpr double kDeviations = 8.0;  // and longer than it by so many deviations
constexpr double kUsuallyChanges = 0.9;
constexpr int kOften = 6;          // a saturated value comes so many times as often as the next one
constexpr int kFewestLevels = 10;  // with fewer levels the sensor is too coarse to tell
constexpr double kForgetting = 5.0;  // weight of a message without a change

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
  // Limits the error, so that one gap does not become the usual interval.
  const double error = std::clamp(dt - usual_s_, -usual_s_, 0.5 * usual_s_);
  if (gap) return true;
  usual_s_ += kLearningRate * error;
  deviation_s_ += kLearningRate * (std::abs(error) - deviation_s_);
  return false;
}

bool StuckWatch::stuck(bool changed) {
  same_ = changed ? 0 : same_ + 1;
  if (same_ <= patience_)
    changing_ += learning_rate_ * (changed ? 1 - changing_ : -kForgetting * changing_);
  return same_ >= patience_ && changing_ > kUsuallyChanges;
}

bool RangeWatch::cut_off(double value) {
  values_.push_back(value);
  if (values_.size() < kWindow) return false;
  std::sort(values_.begin(), values_.end());
  const auto at_end = [](auto begin, auto end) {
    const auto next = std::find_if(begin, end, [&](double v) { return v != *begin; });
    if (next == end) return false;  // never changes
    const auto after = std::find_if(next, end, [&](double v) { return v != *next; });
    return next - begin >= kOften && next - begin >= kOften * (after - next);
  };
  const bool found =
      at_end(values_.begin(), values_.end()) || at_end(values_.rbegin(), values_.rend());
  const auto levels = std::unique(values_.begin(), values_.end()) - values_.begin();
  values_.clear();
  return found && levels >= kFewestLevels;
}

std::string ImuWatch::check(const ImuSample& sample) {
  Values values;
  values << sample.acceleration, sample.angular_velocity;
  const bool stuck = all_.stuck(values != last_);
  bool stays = false;
  cut_off_ = false;
  for (int i = 0; i < 6; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    stays |= axes_[axis].stuck(values[i] != last_[i]);
    cut_off_ |= ranges_[axis].cut_off(values[i]);
  }
  last_ = values;
  if (stuck) return kStuck;
  return stays ? "one axis stays, as at the end of its range" : "";
}

std::string ImuWatch::quality() const {
  return cut_off_ ? "values cut off at the end of a range" : "";
}

std::string TraceWatch::check(const GprTrace& trace, double wheel_m) {
  const bool changed = trace.samples != last_;
  if (changed) changed_at_m_ = wheel_m;
  const bool stuck = stuck_.stuck(changed) || std::abs(wheel_m - changed_at_m_) > kGoesFar;
  last_ = trace.samples;
  return stuck ? kStuck : "";
}

std::string TraceWatch::quality(const GprTrace& trace) {
  const auto quality = check_.check(trace.samples.data(), static_cast<int>(trace.samples.size()));
  dead_ = quality == gpr::TraceQuality::kDead;
  if (dead_) return "trace without a signal";
  return quality == gpr::TraceQuality::kSpiked ? "trace with a spike" : "";
}

}  // namespace gprodom
