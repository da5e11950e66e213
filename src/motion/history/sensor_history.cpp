#include "motion/history/sensor_history.h"

#include <algorithm>
#include <cmath>

#include "base/by_time.h"

namespace gprodom {

namespace {

// Drops all entries before `time` except the last, which interpolation needs.
template <typename Entries>
void forget(Entries& entries, TimeNs time) {
  const auto keep = first_after(entries, time);
  if (keep - entries.begin() > 1) entries.erase(entries.begin(), keep - 1);
}

constexpr double kStampError_s = 0.02;
constexpr TimeNs kGap = 120'000'000;  // ns, of the IMU, at least
constexpr TimeNs kLongGap = from_seconds(kLongestBridge);
constexpr TimeNs kBridgeStep = 20'000'000;  // ns

ImuSample interpolate(const ImuSample& a, const ImuSample& b, TimeNs time) {
  const double u = b.time > a.time ? share_of_way(a.time, b.time, time) : 0.0;
  return {time, a.acceleration + u * (b.acceleration - a.acceleration),
          a.angular_velocity + u * (b.angular_velocity - a.angular_velocity)};
}

}  // namespace

bool ImuHistory::insert(const ImuSample& sample) {
  const auto next = first_after(samples_, sample.time);
  if (next != samples_.begin() && (next - 1)->time == sample.time) return false;
  if (next == samples_.end() && !samples_.empty()) {
    const TimeNs took = sample.time - samples_.back().time, most = period_ / 50;
    period_ = period_ == 0 ? took : period_ + std::clamp(took - period_, -most, most);
  }
  samples_.insert(next, sample);
  return true;
}

TimeNs ImuHistory::gap() const {
  constexpr double kPeriods = 3.4;
  return std::clamp(static_cast<TimeNs>(kPeriods * static_cast<double>(period_)), kGap, kLongGap);
}

void ImuHistory::divide_forces(double accel_scale) {
  for (ImuSample& sample : samples_) sample.acceleration /= accel_scale;
}

void ImuHistory::turn(const Eigen::Matrix3d& R_new_old) {
  for (ImuSample& sample : samples_) {
    sample.acceleration = (R_new_old * sample.acceleration).eval();
    sample.angular_velocity = (R_new_old * sample.angular_velocity).eval();
  }
}

void ImuHistory::forget_before(TimeNs time) { forget(samples_, time); }

std::vector<ImuSample> ImuHistory::between(TimeNs from, TimeNs to) const {
  return {first_after(samples_, from - 1), first_after(samples_, to)};
}

std::vector<ImuSample> ImuHistory::last(std::size_t count, TimeNs to) const {
  const auto end = first_after(samples_, to);
  const auto kept = static_cast<std::size_t>(end - samples_.begin());
  return {end - static_cast<std::ptrdiff_t>(std::min(count, kept)), end};
}

std::optional<std::pair<ImuSample, ImuSample>> ImuHistory::around(TimeNs time) const {
  const auto next = first_after(samples_, time);
  if (next == samples_.begin() || next == samples_.end()) return std::nullopt;
  return std::pair{*(next - 1), *next};
}

std::vector<MotionStep> ImuHistory::steps(TimeNs from, TimeNs to, TimeNs max_gap) const {
  std::vector<MotionStep> steps;
  if (samples_.empty() || to <= from) return steps;
  if (max_gap == 0) max_gap = gap();
  // Beyond the ends of the data the nearest sample is used.
  auto at = [&](const decltype(samples_)::const_iterator& next, TimeNs time) {
    if (next == samples_.begin()) return interpolate(*next, *next, time);
    if (next == samples_.end()) return interpolate(samples_.back(), samples_.back(), time);
    return interpolate(*(next - 1), *next, time);
  };
  auto next = first_after(samples_, from);
  ImuSample left = at(next, from);
  while (left.time < to) {
    TimeNs end = next == samples_.end() ? to : std::min(to, next->time);
    const TimeNs before = next == samples_.begin() ? from : (next - 1)->time;
    const TimeNs after = next == samples_.end() ? to : next->time;
    // A gap is cut into several steps. In a single one, the noises of velocity and position would
    // be fully correlated.
    if (after - before > max_gap) end = std::min(end, left.time + kBridgeStep);
    const ImuSample right = at(next, end);
    steps.push_back({to_seconds(end - left.time), 0.5 * (left.acceleration + right.acceleration),
                     0.5 * (left.angular_velocity + right.angular_velocity), 0.0,
                     after - before > max_gap, after - before > kLongGap, std::nullopt});
    left = right;
    left.time = end;
    if (next != samples_.end() && next->time <= end) ++next;
  }
  return steps;
}

void WheelHistory::resume(const WheelSample& sample) {
  *this = WheelHistory(max_speed_, gains_most_);
  insert(sample);
  resumed_at_ = sample.time;
}

bool WheelHistory::insert(const WheelSample& sample) {
  const auto next = first_after(entries_, sample.time);
  if (next == entries_.begin()) {
    entries_.push_front({sample.time, sample.distance_m,
                         entries_.empty() ? sample.distance_m
                                          : entries_.front().distance_m + sample.distance_m -
                                                entries_.front().reported,
                         false});
    return true;
  }
  const Entry& before = *(next - 1);
  const double moved = sample.distance_m - before.reported;
  const double dt = to_seconds(sample.time - before.time);
  const bool newest = next == entries_.end();
  // A stamp may be wrong by some milliseconds, so 20 ms are added. Those of a busy computer come
  // closer together than the samples were taken.
  const double took = std::max(dt + kStampError_s, period_s_);
  const bool jumped =
      newest ? !plausible(std::abs(moved) / took) : std::abs(moved) > fastest() * took;
  jump_found_ |= jumped && !newest;
  if (newest && !jumped) watch_repeats(before, sample.time, moved / dt);
  entries_.insert(
      next, {sample.time, sample.distance_m, before.distance_m + (jumped ? 0.0 : moved), jumped});
  return !jumped;
}

double WheelHistory::fastest() const {
  return std::max(max_speed_ > 0 ? max_speed_ : gains_most_, 2 * usual_speed_);
}

// A vehicle that is faster reaches its speed gradually, or has it from the first sample on: several
// increments in a row that agree are no jumps.
bool WheelHistory::plausible(double speed) {
  constexpr double kLearningRate = 0.5, kAgrees = 0.2;
  constexpr int kEnough = 5;
  const bool pending = max_speed_ == 0 && fast_in_a_row_ > 0;
  if (speed <= fastest()) {
    jump_found_ |= pending;
    usual_speed_ += kLearningRate * (speed - usual_speed_);
    fast_in_a_row_ = 0;
    return true;
  }
  const bool agrees = std::abs(speed - fast_speed_) < kAgrees * fast_speed_;
  jump_found_ |= max_speed_ > 0 || (pending && !agrees);
  fast_in_a_row_ = agrees ? fast_in_a_row_ + 1 : 1;
  fast_speed_ = speed;
  if (fast_in_a_row_ < kEnough) return false;
  usual_speed_ = speed;
  fast_in_a_row_ = 0;
  return false;
}

// Repeated values have the same speed, apart from rounding.
void WheelHistory::watch_repeats(const Entry& before, TimeNs time, double speed) {
  constexpr double kSame = 0.005, kSlowest = 0.05, kLongest_s = 1.0, kStep = 0.05;
  if (std::abs(speed) < kSlowest) {
    changed_at_ = 0;
    return;
  }
  // Converges to the median.
  const auto learn = [](double& usual, double seen) {
    usual += seen > usual ? kStep * seen : -kStep * usual;
  };
  learn(period_s_, to_seconds(time - before.time));
  if (std::abs(speed - changed_to_) < kSame * std::abs(speed)) return;
  const double every = to_seconds(time - changed_at_);
  if (changed_at_ > 0 && every < kLongest_s) learn(changes_every_s_, every);
  changed_at_ = time;
  changed_to_ = speed;
}

void WheelHistory::forget_before(TimeNs time) { forget(entries_, time); }

std::optional<double> WheelHistory::distance(TimeNs time, bool across_gaps) const {
  return value(time, &Entry::distance_m, across_gaps);
}

bool WheelHistory::jumped_since(TimeNs time) const {
  return std::any_of(first_after(entries_, time), entries_.end(),
                     [](const Entry& e) { return e.jumped; });
}

std::optional<TimeNs> WheelHistory::newest(TimeNs time) const {
  const auto later = first_after(entries_, time);
  if (later == entries_.begin()) return std::nullopt;
  return (later - 1)->time;
}

std::optional<double> WheelHistory::reported(TimeNs time) const {
  return value(time, &Entry::reported, false);
}

std::optional<double> WheelHistory::value(TimeNs time, double Entry::*member,
                                          bool across_gaps) const {
  const auto next = first_after(entries_, time);
  if (next == entries_.begin()) return std::nullopt;
  const Entry& a = *(next - 1);
  if (a.time == time) return a.*member;
  if (next == entries_.end()) return std::nullopt;
  const bool gap = next->time - a.time > kMaxGap && a.time != resumed_at_ && !across_gaps;
  if (next->jumped || gap) return std::nullopt;
  return a.*member + share_of_way(a.time, next->time, time) * ((*next).*member - a.*member);
}

double WheelHistory::path(TimeNs from, TimeNs to) const {
  double sum = 0;
  for (auto i = first_after(entries_, from - 1); i != entries_.end() && i->time <= to; ++i)
    if (i != entries_.begin()) sum += std::abs(i->distance_m - (i - 1)->distance_m);
  return sum;
}

TimeNs WheelHistory::still_since(TimeNs from, double most_m) const {
  double sum = 0;
  for (auto i = entries_.rbegin(); i != entries_.rend() && i + 1 != entries_.rend(); ++i) {
    if (i->time <= from) return from;
    sum += std::abs(i->distance_m - (i + 1)->distance_m);
    if (sum > most_m) return i->time;
  }
  return from;
}

std::pair<TimeNs, TimeNs> WheelHistory::still_from(TimeNs from, double most_m) const {
  const auto first = std::find_if(entries_.begin(), entries_.end(),
                                  [from](const Entry& e) { return e.time >= from; });
  if (first == entries_.end()) return {from, from};
  double sum = 0;
  auto last = first;
  for (auto next = std::next(first); next != entries_.end(); last = next++) {
    sum += std::abs(next->distance_m - last->distance_m);
    if (sum > most_m) break;
  }
  return {first->time, last->time};
}

bool set_wheel_distances(std::vector<MotionStep>& steps, const WheelHistory& wheel, TimeNs from,
                         bool across_gaps) {
  double elapsed = 0;
  std::optional<double> before = wheel.distance(from, across_gaps);
  for (MotionStep& step : steps) {
    elapsed += step.dt;
    const std::optional<double> after = wheel.distance(from + from_seconds(elapsed), across_gaps);
    if (!before || !after) {
      for (MotionStep& s : steps) s.wheel_m = 0;
      return false;
    }
    step.wheel_m = *after - *before;
    before = after;
  }
  return !steps.empty();
}

}  // namespace gprodom
