#include "motion/wheel_pair.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

// The other side's error against the published velocity must be less than this share of the
// slipping side's.
constexpr double kOtherSide = 0.5;

constexpr std::size_t kRecent = 5;                // intervals tested together for common slip
constexpr double kAgrees = 2.0, kDetected = 3.0;  // standard deviations

}  // namespace

WheelPair::WheelPair(const WheelConfig& config)
    : config_(config),
      difference_(2 * config.max_speed, 2 * WheelHistory::kGainsMost),
      calibration_(drive_traits(config), config.noise_floor) {}

bool WheelPair::insert(const WheelsSample& sample) {
  received_ = true;
  return difference_.insert({sample.time, sample.right_m - sample.left_m});
}

// The mean of two sides has a quarter of the variance of their difference.
double WheelPair::middle_noise() const {
  const bool learnt = received_ && drive_traits(config_).turns_by_difference;
  return learnt ? 0.5 * calibration_.measured_noise_per_middle() : 0.0;
}

std::optional<LearntTurn> WheelPair::learnt() const {
  if (!received_ || !drive_traits(config_).turns_by_difference) return std::nullopt;
  return calibration_.learnt();
}

void WheelPair::forget_before(TimeNs time) { difference_.forget_before(time); }

std::optional<std::vector<WheelPair::Step>> WheelPair::steps_of(const StateInput& input,
                                                                TimeNs from,
                                                                const Eigen::Vector3d& gyro_bias,
                                                                const WheelHistory& wheel,
                                                                bool across_gaps) const {
  std::vector<Step> steps;
  double elapsed = 0.0;
  auto middle = wheel.distance(from, across_gaps), apart = difference_.distance(from, across_gaps);
  for (const MotionStep& s : input.steps) {
    elapsed += s.dt;
    const TimeNs time = from + from_seconds(elapsed);
    const auto next_middle = wheel.distance(time, across_gaps);
    const auto next_apart = difference_.distance(time, across_gaps);
    if (!middle || !apart || !next_middle || !next_apart) return std::nullopt;
    Step step{{*next_middle - *middle, *next_apart - *apart, 0.0},
              (s.angular_velocity - gyro_bias).z() * s.dt};
    const double half = 0.5 * step.motion.difference_m;
    step.motion.path_m =
        std::abs(step.motion.middle_m - half) + std::abs(step.motion.middle_m + half);
    steps.push_back(step);
    middle = next_middle;
    apart = next_apart;
  }
  return steps;
}

void WheelPair::complete(StateInput& input, TimeNs from, const NavState& newest,
                         const WheelHistory& wheel, std::optional<double> ground_m) {
  slipping_ = SlippingSide::kNone;
  const bool in_gap = imu_silent(input.steps);
  if (!in_gap) in_gap_ = {};
  const auto steps = steps_of(input, from, newest.gyro_bias, wheel, in_gap);
  if (!steps || !drive_traits(config_).turns_by_difference) return interrupt();
  if (in_gap) {
    interrupt();
    return replace_gyro(input, *steps);
  }
  Stretch whole;
  whole.seconds = to_seconds(input.time - from);
  for (const Step& step : *steps) {
    whole.motion += step.motion;
    whole.turn.rad += step.turned_rad;
  }
  if (!recent_.empty()) {
    const Stretch& last = recent_.back();
    whole.turn.rate_change = whole.turn.rad / whole.seconds - last.turn.rad / last.seconds;
  }
  if (ground_m) {
    whole.ground_m = *ground_m * newest.wheel_scale;
    slipping_ = judge(whole);
  }
  if (slipping_ != SlippingSide::kNone) {
    interrupt();
    return use_other_side(input, *steps);
  }
  calibration_.learn(whole.motion, whole.turn.rad, whole.seconds);
  recent_.push_back(whole);
  if (recent_.size() > kRecent) recent_.pop_front();
  if (input.wheel_contradicted && ground_m && rules_out_common_slip())
    input.wheel_contradicted = false;
}

void WheelPair::interrupt() {
  calibration_.interrupt();
  recent_.clear();
}

// The other side does not slip: its distance and the gyro's turn give that of the middle.
void WheelPair::use_other_side(StateInput& input, const std::vector<Step>& steps) const {
  const double side = slipping_ == SlippingSide::kLeft ? 1.0 : -1.0;  // the other is right, or left
  for (size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    const double good = step.motion.middle_m + side * 0.5 * step.motion.difference_m;
    input.steps[i].wheel_m = (good - side * 0.5 * calibration_.track_m() * step.turned_rad) /
                             (1 + side * 0.5 * calibration_.radii_difference());
  }
  input.has_wheel = true;
  input.wheel_contradicted = false;
}

// The errors of track and radii are constant through a gap. So the variance is computed for the
// whole gap, and each interval adds the growth.
void WheelPair::replace_gyro(StateInput& input, const std::vector<Step>& steps) {
  const double before = in_gap_.path_m > 0 ? calibration_.turn_variance(in_gap_) : 0.0;
  for (size_t i = 0; i < steps.size(); ++i) {
    if (!input.steps[i].long_gap) continue;
    input.steps[i].gap_turn = calibration_.turn(steps[i].motion);
    in_gap_ += steps[i].motion;
  }
  const double after = in_gap_.path_m > 0 ? calibration_.turn_variance(in_gap_) : 0.0;
  input.turn_variance = std::max(0.0, after - before);
}

// Of right less left against the gyro, with its standard deviation.
std::pair<double, double> WheelPair::error_of(const Stretch& stretch) const {
  const PairMotion& motion = stretch.motion;
  return {motion.difference_m - calibration_.expected_difference(motion.middle_m, stretch.turn),
          std::sqrt(calibration_.difference_variance(motion, stretch.turn))};
}

// One side slips if left, right and gyro disagree, and the other side agrees with the published
// velocity.
SlippingSide WheelPair::judge(const Stretch& whole) const {
  const PairMotion& motion = whole.motion;
  const auto [error, sigma] = error_of(whole);
  const double threshold = config_.slip_threshold;
  if (threshold <= 0 || std::abs(error) < threshold * sigma) return SlippingSide::kNone;
  const double half = 0.5 * motion.difference_m;
  const double rolled = 0.5 * calibration_.expected_difference(whole.ground_m, whole.turn);
  const double left = std::abs(motion.middle_m - half - (whole.ground_m - rolled));
  const double right = std::abs(motion.middle_m + half - (whole.ground_m + rolled));
  if (std::min(left, right) > kOtherSide * std::max(left, right)) return SlippingSide::kNone;
  return left > right ? SlippingSide::kLeft : SlippingSide::kRight;
}

// By the published velocity both sides slip by the same share. In a bend their difference would
// then disagree with the gyro. If it would be detected but is not there, the velocity is wrong.
bool WheelPair::rules_out_common_slip() const {
  Stretch last;
  for (const Stretch& each : recent_) {
    last.motion += each.motion;
    last.turn += each.turn;
    last.ground_m += each.ground_m;
  }
  const PairMotion& motion = last.motion;
  const auto [error, sigma] = error_of(last);
  const double larger = std::max(std::abs(motion.middle_m), std::abs(last.ground_m));
  const double share = larger > 0 ? std::abs(motion.middle_m - last.ground_m) / larger : 0.0;
  return std::abs(error) < kAgrees * sigma &&
         share * std::abs(motion.difference_m) > (kAgrees + kDetected) * sigma;
}

}  // namespace gprodom
