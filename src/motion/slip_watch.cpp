#include "motion/slip_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom {

namespace {

// Over which wheel and IMU are compared. A slip begins within it; over a longer one the error of
// the published velocity grows and hides it.
constexpr double kCompared_s = 0.3;

// A slip is over if the share that slips has fallen, within kEndsWithin, below kEndsBelow of what
// it was: the end is a jump like the onset. Where it falls for longer, the velocity drifts towards
// the slipping wheel's. It is over as well if wheel and velocity agree within kAgreesAgain standard
// deviations, and would not if the wheel slipped as before: over a slip the velocity's variance
// grows until any wheel agrees. After the length of the smoother's window any agreement will do,
// since a wheel that slips is better than none.
constexpr double kAgreesAgain = 2.0, kEndsBelow = 0.5;
constexpr TimeNs kEndsWithin = 1'000'000'000;  // ns

constexpr double kBeyond = 3.0;       // standard deviations; a speed to which no slip can lead
constexpr double kWheelSpeed = 0.1;   // m/s; sigma of its mean over kCompared_s
constexpr double kDrives_mps = 0.05;  // below, the robot stands or nearly, and errors are smaller

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
    if (!speed_known) slipped_.clear();
    now_ = WheelSlip::kNone;
    speed_wrong_since_.reset();
  }
  const TimeNs to = std::min(wheel_now, estimate.time), from = to - window_;
  if (to <= judged_) return;
  judged_ = to;
  const auto moved = distances(from, to, wheel, estimate.wheel_scale);
  if (!speed_known || !moved) {
    now_ = WheelSlip::kNone;
    return;
  }
  const double unexplained = variance(estimate, *moved);
  const WheelSlip seen = judge(*moved, unexplained);
  learn_tail(to, seen, *moved, unexplained);
  now_ = seen;
  follow_share(to, share_of(*moved));
  check_ground_speed(estimate.velocity_covariance(0, 0), speed, *moved);
  if (now_ != WheelSlip::kNone) mark(from, to);
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

// The force of a wheel that slips changes the ground's speed towards the wheel's. So that speed
// stays between zero, what it was at the onset, and the wheel's. Where it is beyond this range by
// as much as the range is wide, the accelerations are wrong and not the wheel.
void SlipWatch::check_ground_speed(double variance, double speed, const Distances& moved) {
  if (now_ == WheelSlip::kNone) {
    least_speed_ = std::min(0.0, speed);
    most_speed_ = std::max(0.0, speed);
    return;
  }
  const double of_wheel = moved.wheel_m / to_seconds(window_);
  least_speed_ = std::min(least_speed_, of_wheel);
  most_speed_ = std::max(most_speed_, of_wheel);
  const double beyond = std::max(least_speed_ - speed, speed - most_speed_);
  if (beyond > most_speed_ - least_speed_ && beyond * beyond > kBeyond * kBeyond * variance)
    speed_wrong_since_ = began_ - window_;
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
  const double threshold = tail_.threshold(config_.slip_threshold);
  const auto within = [&](double deviations) {
    return innovation * innovation < deviations * deviations * variance;
  };
  const double larger = std::max(std::abs(moved.wheel_m), std::abs(moved.ground_m));
  const double in_slip = largest_share_ * larger;  // the innovation, if the wheel slips as before
  const bool tells = in_slip * in_slip > 4 * kAgreesAgain * kAgreesAgain * variance ||
                     judged_ > began_ + smoother_window_;
  const bool over = jumped_back_ || (tells && within(kAgreesAgain));
  const bool slips = now_ != WheelSlip::kNone && !over;
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

std::optional<SpeedCorrection> SlipWatch::take_speed_correction(TimeNs time,
                                                                const WheelHistory& wheel,
                                                                double wheel_scale) {
  const auto since = std::exchange(speed_wrong_since_, std::nullopt);
  if (!since || track_.empty()) return std::nullopt;
  const auto all = distances(std::max(*since, track_.begin()), time, wheel, wheel_scale);
  const auto last = distances(time - window_, time, wheel, wheel_scale);
  if (!all || !last) return std::nullopt;
  slipped_.clear();
  now_ = WheelSlip::kNone;
  track_ = {};  // it holds the wrong velocity
  return SpeedCorrection{last->wheel_m / to_seconds(window_), kWheelSpeed,
                         all->wheel_m - all->ground_m};
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
