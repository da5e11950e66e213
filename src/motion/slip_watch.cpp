#include "motion/slip_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom {

namespace {

// Over which wheel and IMU are compared. A slip begins within it; over a longer one the error of
// the published velocity grows and hides it.
constexpr double kCompared_s = 0.3;

constexpr TimeNs kSilentAfter = 1'000'000'000;  // ns
constexpr double kThresholdAfterSilence = 3.0;  // standard deviations

// A slip is over if the share that slips has fallen, within kEndsWithin, below kEndsBelow of what
// it was: the end is a jump like the onset. Where it falls for longer, the velocity drifts towards
// the slipping wheel's. It is over as well if wheel and velocity agree within kAgreesAgain standard
// deviations, and would not if the wheel slipped as before: over a slip the velocity's variance
// grows until any wheel agrees. After the length of the smoother's window any agreement will do,
// since a wheel that slips is better than none.
constexpr double kAgreesAgain = 2.0, kEndsBelow = 0.5;
constexpr TimeNs kEndsWithin = 1'000'000'000;  // ns

constexpr TimeNs kRadarAgreesFor = 2'000'000'000;  // ns
constexpr double kRadarAgrees = 2.0,
                 kRadarDisagrees = 3.0;  // standard deviations of the radar's distance
constexpr double kTrackCovers = 0.5;     // least share of the radar's interval
constexpr double kWheelSpeed = 0.1;      // m/s; sigma of its mean over kCompared_s
constexpr double kDrives_mps = 0.05;  // below, the robot stands or nearly, and errors are smaller

double deviations_from(const Displacement& radar, double m) {
  return std::abs(std::abs(m) - radar.distance_m) / radar.sigma_m;
}

}  // namespace

SlipWatch::SlipWatch(const WheelConfig& config, double window_s)
    : config_(config),
      smoother_window_(from_seconds(window_s)),
      window_(from_seconds(kCompared_s)),
      wheel_sigma_m_(config.noise_floor),
      wheel_floor_m_(config.noise_floor) {}

void SlipWatch::set_wheel_error(const WheelError& error) {
  pair_noise_ = error.noise;
  wheel_floor_m_ = error.floor_m;
  wheel_sigma_m_ = std::max(error.floor_m, error.sigma_m);
  window_ = from_seconds(std::max(kCompared_s, 2 * error.late_s));
  late_ = from_seconds(error.late_s);
}

void SlipWatch::add(const OdometryEstimate& estimate, const WheelHistory& wheel, TimeNs wheel_now,
                    bool speed_known) {
  if (!config_.enabled || config_.slip_threshold <= 0) return;
  const double speed = (estimate.v_body + estimate.omega_body.cross(config_.lever_arm)).x();
  if (!track_.empty() && estimate.time > track_.end() + window_) track_ = {};  // after a gap
  track_.advance(estimate.time, speed);
  track_.forget_before(estimate.time - kMemory);
  while (!slipped_.empty() && slipped_.front().to < estimate.time - kMemory) slipped_.pop_front();

  if (speed_known != std::exchange(speed_known_, speed_known)) {
    back_from_silence_ |= speed_known && slip_by_radar_ != WheelSlip::kNone;
    if (!speed_known) slipped_.clear();
    slip_by_radar_ = now_ = WheelSlip::kNone;
    radar_agrees_ = {0, 0};
    speed_error_.reset();
  }
  if (estimate.time > wheel_now + kSilentAfter) back_from_silence_ = true;
  const TimeNs to = std::min(wheel_now, estimate.time), from = to - window_;
  if (to <= judged_) return;
  judged_ = to;
  const auto moved = distances(from, to, wheel, estimate.wheel_scale);
  const double unexplained = moved ? variance(estimate, *moved) : 0.0;
  const WheelSlip seen = moved ? judge(*moved, unexplained) : WheelSlip::kNone;
  if (speed_known && moved) learn_tail(to, seen, *moved, unexplained);
  now_ = slip_by_radar_;
  if (speed_known && moved) {
    now_ = seen;
    follow_share(to, share_of(*moved));
    if (now_ == WheelSlip::kNone) back_from_silence_ = false;
  }
  if (now_ != WheelSlip::kNone || (!moved && back_from_silence_)) mark(from, to);
}

// Of the larger distance. Constant in a slip, at any speed.
double SlipWatch::share_of(const Distances& moved) {
  const double larger = std::max(std::abs(moved.wheel_m), std::abs(moved.ground_m));
  return larger > 0 ? std::abs(moved.wheel_m - moved.ground_m) / larger : 0.0;
}

void SlipWatch::follow_share(TimeNs time, double share) {
  if (now_ == WheelSlip::kNone) {
    shares_.clear();
    jumped_back_ = false;
    largest_share_ = 0.0;
    began_ = time;
    return;
  }
  while (!shares_.empty() && shares_.front().time < time - kEndsWithin) shares_.pop_front();
  jumped_back_ |= std::any_of(shares_.begin(), shares_.end(), [share](const Share& earlier) {
    return share < kEndsBelow * earlier.value;
  });
  shares_.push_back({time, share});
  largest_share_ = std::max(largest_share_, share);
}

// Of a slip only the onset counts.
void SlipWatch::learn_tail(TimeNs time, WheelSlip seen, const Distances& moved, double variance) {
  const bool slips = seen != WheelSlip::kNone;
  const bool goes_on = slips ? now_ != WheelSlip::kNone : time < tail_time_ + window_;
  if (goes_on || std::abs(moved.wheel_m) < kDrives_mps * to_seconds(window_)) return;
  tail_.add(std::pow(moved.wheel_m - moved.ground_m, 2) / variance);
  tail_time_ = time;
}

// Of the difference between both, m^2. The velocity's error is constant over the window. The
// wheel's errors are those of its factor. Of the noise learnt by driving and that learnt from the
// two sides the larger one counts: both contain the same slip.
double SlipWatch::variance(const OdometryEstimate& estimate, const Distances& moved) const {
  const double seconds = to_seconds(window_);
  const auto of_wheel = [&](double noise, double sigma_m) {
    return noise * noise * std::abs(moved.ground_m) + 2 * sigma_m * sigma_m;
  };
  return estimate.velocity_covariance(0, 0) * seconds * seconds +
         std::pow(estimate.wheel_scale_sigma * moved.ground_m, 2) +
         std::max(of_wheel(config_.noise, wheel_sigma_m_), of_wheel(pair_noise_, wheel_floor_m_)) +
         moved.by_delay_m * moved.by_delay_m;
}

WheelSlip SlipWatch::judge(const Distances& moved, double variance) const {
  const double innovation = moved.wheel_m - moved.ground_m;
  const double threshold =
      tail_.threshold(back_from_silence_ ? std::min(kThresholdAfterSilence, config_.slip_threshold)
                                         : config_.slip_threshold);
  const auto within = [&](double deviations) {
    return innovation * innovation < deviations * deviations * variance;
  };
  const double larger = std::max(std::abs(moved.wheel_m), std::abs(moved.ground_m));
  const double in_slip = largest_share_ * larger;  // the innovation, if the wheel slips as before
  const bool tells = in_slip * in_slip > 4 * kAgreesAgain * kAgreesAgain * variance ||
                     judged_ > began_ + smoother_window_;
  const bool over = jumped_back_ || (tells && within(kAgreesAgain));
  const bool slips = now_ != WheelSlip::kNone && speed_known_ && !over;
  if (!slips && within(threshold)) return WheelSlip::kNone;
  return innovation * moved.wheel_m > 0 ? WheelSlip::kFast : WheelSlip::kSlow;
}

std::optional<SlipWatch::Distances> SlipWatch::distances(TimeNs from, TimeNs to,
                                                         const WheelHistory& wheel,
                                                         double wheel_scale) const {
  const auto wheel_from = wheel.distance(from), wheel_to = wheel.distance(to);
  if (track_.empty() || from < track_.begin() || !wheel_from || !wheel_to) return std::nullopt;
  const double ground_m = track_.path(to) - track_.path(from);
  const double earlier_m = track_.path(to - late_) - track_.path(from - late_);
  return Distances{(*wheel_to - *wheel_from) / wheel_scale, ground_m, ground_m - earlier_m};
}

std::optional<double> SlipWatch::ground(TimeNs from, TimeNs to) const {
  if (!speed_known_ || track_.empty() || from < track_.begin() || to > track_.end())
    return std::nullopt;
  return track_.path(to) - track_.path(from);
}

void SlipWatch::compare_with_radar(const Displacement& radar, const WheelHistory& wheel,
                                   double wheel_scale) {
  if (!speed_known_) {
    judge_by_radar_alone(radar, wheel, wheel_scale);
    return;
  }
  const bool slips =
      now_ != WheelSlip::kNone && !slipped_.empty() && slipped_.back().from <= radar.from;
  const auto moved = slips ? distances(radar.from, radar.to, wheel, wheel_scale) : std::nullopt;
  if (!moved || deviations_from(radar, moved->wheel_m) > kRadarAgrees ||
      deviations_from(radar, moved->ground_m) < kRadarDisagrees) {
    radar_agrees_ = {0, 0};
    return;
  }
  if (radar_agrees_.to < radar.from) radar_agrees_.from = radar.from;
  radar_agrees_.to = radar.to;
}

// The published velocity has followed the wheel, so both may be wrong. The track may begin inside
// the radar's interval, at the end of the IMU's gap.
void SlipWatch::judge_by_radar_alone(const Displacement& radar, const WheelHistory& wheel,
                                     double wheel_scale) {
  const auto wheel_from = wheel.distance(radar.from, true), wheel_to = wheel.distance(radar.to);
  const TimeNs since = track_.empty() ? radar.to : std::max(radar.from, track_.begin());
  const double covered =
      static_cast<double>(radar.to - since) / static_cast<double>(radar.to - radar.from);
  if (!wheel_from || !wheel_to) return;
  const double wheel_m = (*wheel_to - *wheel_from) / wheel_scale;
  const double ground_m = (track_.path(radar.to) - track_.path(since)) / covered;
  const double wheel_deviations = deviations_from(radar, wheel_m);
  if (wheel_deviations < kRadarAgrees)
    slip_by_radar_ = WheelSlip::kNone;
  else
    slip_by_radar_ = std::abs(wheel_m) > radar.distance_m ? WheelSlip::kFast : WheelSlip::kSlow;
  if (covered < kTrackCovers || deviations_from(radar, ground_m) < kRadarAgrees) return;
  const double seconds = to_seconds(radar.to - radar.from);
  speed_error_ = SpeedError{since, slip_by_radar_ == WheelSlip::kNone,
                            (std::copysign(radar.distance_m, ground_m) - ground_m) / seconds,
                            radar.sigma_m / seconds};
}

std::optional<SpeedCorrection> SlipWatch::take_speed_correction(TimeNs time,
                                                                const WheelHistory& wheel,
                                                                double wheel_scale) {
  const bool taken_back =
      radar_agrees_.to - radar_agrees_.from >= kRadarAgreesFor && !slipped_.empty();
  const auto error = std::exchange(speed_error_, std::nullopt);
  if ((!taken_back && !error) || track_.empty()) return std::nullopt;
  radar_agrees_ = {0, 0};  // not kept for later: if the wheel is silent now, it would be stale
  const TimeNs since = taken_back ? slipped_.back().from : error->since;
  const auto all = distances(std::max(since, track_.begin()), time, wheel, wheel_scale);
  const auto last = distances(time - window_, time, wheel, wheel_scale);
  if (!all || !last) return std::nullopt;
  SpeedCorrection correction{last->wheel_m / to_seconds(window_), kWheelSpeed,
                             all->wheel_m - all->ground_m};
  if (!taken_back && !error->wheel_right) {
    // The IMU gives the change of speed since the middle of the radar's interval.
    correction = {last->ground_m / to_seconds(window_) + error->speed_change, error->sigma,
                  error->speed_change * to_seconds(time - since)};
  } else {
    slipped_.clear();
    now_ = WheelSlip::kNone;
  }
  track_ = {};  // it holds the wrong velocity
  return correction;
}

void SlipWatch::mark(TimeNs from, TimeNs to) {
  if (!slipped_.empty() && from <= slipped_.back().to)
    slipped_.back().to = to;
  else
    slipped_.push_back({from, to, to});
}

bool SlipWatch::between(TimeNs from, TimeNs to, TimeNs heard) const {
  return std::any_of(slipped_.begin(), slipped_.end(), [&](const Interval& s) {
    return s.found <= heard && s.from < to && s.to > from;
  });
}

}  // namespace gprodom
