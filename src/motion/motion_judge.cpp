#include "motion/motion_judge.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "estimation/drive_traits.h"
#include "estimation/factors.h"
#include "estimation/increments/wheel_increment.h"
#include "motion/radar_finding.h"
#include "motion/rest/imu_noise.h"

namespace gprodom {

namespace {

// Largest ratio of the noise over seconds, which driving shows, to that from sample to sample. Real
// robots and cars have 1 to 8; what lies beyond is lasting slip.
constexpr double kLargestDensityRatio = 10.0;

// How long samples are kept while no state is made (before the start, or without an IMU).
constexpr TimeNs kLongestSilence = 100 * kSecond;
constexpr std::size_t kMostDisplacements = 2000;  // external displacements

}  // namespace

MotionJudge::MotionJudge(const Config& config)
    : config_(config),
      wheel_floor_m_(config.wheel.noise_floor),
      state_period_(from_seconds(1 / config.smoother.state_rate)),
      lag_(from_seconds(config.smoother.lag)),
      wheel_(config.wheel.max_speed),
      pair_(config.wheel),
      slip_(config.wheel, config.smoother.lag),
      slip_belief_(config),
      pair_slip_(config) {}

bool MotionJudge::add(const ImuSample& sample) {
  if (first_imu_ == 0) first_imu_ = sample.time;
  imu_now_ = std::max(imu_now_, sample.time);
  return imu_.insert(sample);
}

void MotionJudge::set_wheel_resolution(double resolution_m) {
  wheel_tick_.set_resolution(resolution_m);
  const double floor_m = std::max(wheel_floor_m_, wheel_tick_.sigma_m());
  config_.wheel.noise_floor = floor_m;
  pair_.set_floor(floor_m);
  slip_belief_.set_wheel_floor(floor_m);
}

void MotionJudge::add(const WheelSample& sample) {
  set_wheel_resolution(sample.resolution_m);
  wheel_now_ = std::max(wheel_now_, sample.time);
  wheel_.forget_before(wheel_now_ - kLongestSilence);
  if (config_.wheel.enabled) wheel_.insert(sample);
}

void MotionJudge::add(const WheelsSample& sample) {
  pair_.forget_before(sample.time - kLongestSilence);
  if (config_.wheel.enabled) pair_.insert(sample);  // a jump is reported by the mean
  add(WheelSample{sample.time, 0.5 * (sample.left_m + sample.right_m), sample.resolution_m});
}

void MotionJudge::add_external(Displacement displacement) {
  if (displacements_.size() < kMostDisplacements)
    displacements_.push_back({PlacedDisplacement(std::move(displacement))});
}

Displacement MotionJudge::in_metres(const gpr::Finding& finding) {
  if (const auto* path = std::get_if<gpr::PathLength>(&finding)) return coherence_.to_metres(*path);
  if (const auto* standstill = std::get_if<gpr::Standstill>(&finding))
    return to_displacement(*standstill);
  return to_displacement(std::get<gpr::TrackDisplacement>(finding));
}

void MotionJudge::add_radar(const gpr::Finding& finding, const PlacedDisplacement& in_metres) {
  radar_heard_ = std::max(radar_heard_, in_metres.to);
  if (!in_metres.valid) return;
  if (const auto* standstill = std::get_if<gpr::Standstill>(&finding)) {
    radar_standing_.push_back(*standstill);
    forget_old_standing();
    const double density = std::max(noise(standstill->to - kSecond, standstill->to).accel_density,
                                    drive_noise_.accel_density());
    immobilised_.add(*standstill, wheel_, imu_, newest_.state.wheel_scale, density);
    return;
  }
  const bool by_coherence = std::holds_alternative<gpr::PathLength>(finding);
  if (by_coherence) {
    slip_.compare_with_radar(in_metres, wheel_, newest_.state.wheel_scale);
    unreported_.push_back(std::get<gpr::PathLength>(finding));
    // A wheel that is silent for so long has no distance for the path when it comes back.
    while (unreported_.front().to < in_metres.to - 2 * kSecond) unreported_.pop_front();
    compare_with_wheel();
  }
  displacements_.push_back({in_metres, by_coherence});
}

void MotionJudge::add_sight(const gpr::Sight& sight) {
  radar_heard_ = std::max(radar_heard_, sight.to);
  gpr::PathLength path;  // its unit is the detection limit times a second
  path.from = sight.from;
  path.to = sight.to;
  path.lengths = sight.times_least * to_seconds(sight.to - sight.from);
  sight_.learn_from(path);
  const auto from = wheel_.distance(sight.from), to = wheel_.distance(sight.to);
  if (from && to) immobilised_.add(sight, *to - *from);
}

std::optional<double> MotionJudge::unseen_speed() const {
  if (sight_.metres_per_length() <= 0.0) return std::nullopt;
  return sight_.metres_per_length() * (1 + 2 * sight_.relative_sigma());
}

// A path with sudden slip in it, or near it, is left out.
void MotionJudge::compare_with_wheel() {
  constexpr TimeNs kMargin = 400'000'000;
  for (; !unreported_.empty() && unreported_.front().to <= wheel_now_; unreported_.pop_front()) {
    const gpr::PathLength& path = unreported_.front();
    const auto from = wheel_.distance(path.from), to = wheel_.distance(path.to);
    if (!from || !to || slip_.between(path.from - kMargin, path.to + kMargin)) continue;
    slip_belief_.compare(path, *to - *from);
    compared_to_ = path.to;
  }
}

void MotionJudge::begin(const StateResult& first, const InitialState& initial) {
  newest_ = first;
  rest_.begin(initial);
  judged_to_ = first.state.time;
}

void MotionJudge::adopt(const StateResult& newest) {
  newest_ = newest;
  immobilised_.add(newest);
  imu_.forget_before(std::min(judged_to_, newest.state.time) - ImmobilisedWatch::kMemory);
  wheel_.forget_before(judged_to_ - std::max(SlipWatch::kMemory, pair_slip_.memory()));
  pair_.forget_before(judged_to_ - SlipWatch::kMemory);
}

ImuNoise MotionJudge::noise(TimeNs from, TimeNs to) const {
  auto samples = imu_.between(from, to);
  if (samples.size() < kEnoughForNoise) samples = imu_.between(to - kSecond, to);
  if (samples.size() < kEnoughForNoise) samples = imu_.last(kEnoughForNoise, to);  // a slow IMU
  ImuNoise noise = prevailing_noise(samples, rest_.noise());
  if (!newest_.standing) {
    const double prevailing = noise.accel_density, most = kLargestDensityRatio * prevailing;
    noise.accel_density = std::max(prevailing, std::min(most, drive_noise_.accel_density()));
    noise.sideways_density = std::min(most, drive_noise_.sideways_density());
  }
  // An error of the accelerations lasts about as long as one of them: a second.
  if (!axes_known_)
    noise.accel_density =
        std::hypot(noise.accel_density, error_of_unknown_axes(imu_.steps(from, to)));
  return noise;
}

double MotionJudge::wheel_delay_s() const {
  constexpr double kShown = 3.0;  // standard deviations
  const TurnCalibration& by_turns = pair_.calibration();
  const bool shown = pair_.received() && by_turns.delay_s() > kShown * by_turns.delay_sigma_s();
  return shown ? by_turns.delay_s() : drive_noise_.wheel_delay_s();
}

AtRest MotionJudge::at_rest() const {
  const double variance = newest_.covariance.diagonal().segment<3>(row::kBg).mean();
  return {rest_.noise(),
          rest_.wheel_mps(),
          newest_.state.gyro_bias,
          std::sqrt(variance),
          unseen_speed().value_or(kUnseenAtFirst),
          rest_.known(),
          config_.gpr.enabled && radar_heard_ + kStandingKept > imu_now_,
          wheel_tick_.longest()};
}

// Unsigned path of the wheel, or of either side of a pair, which also turns on the spot.
double MotionJudge::rolled(TimeNs from, TimeNs to) const {
  return std::max(wheel_.path(from, to), pair_.path(from, to));
}

// While no standstill is known, a wheel that turns slowly may be noisy at rest, or the robot may be
// braking. Braking ends within two seconds.
bool MotionJudge::stands_with_engine(TimeNs now) {
  constexpr TimeNs kLongerThanBraking = 2 * kSecond;
  const TimeNs from = now - from_seconds(LastSecond::kBefore),
               to = now + from_seconds(LastSecond::kAfter);
  bool stands = config_.standstill.enabled && wheel_.distance(from) && wheel_.distance(to);
  if (stands) {
    const LastSecond last{
        imu_.between(from, to), rolled(std::min(from, to - wheel_tick_.longest()), to),
        rolled(to - from_seconds(LastSecond::kLately), to), newest_.state.v_odom.norm()};
    AtRest vibrating = at_rest();
    vibrating.noise = rest_.vibration();
    stands = stands_for_a_second(config_.wheel, vibrating, vibration_, last);
  }
  stands_in_a_row_ = stands ? stands_in_a_row_ + 1 : 0;
  return stands && (rest_.known() || stands_in_a_row_ * state_period_ >= kLongerThanBraking);
}

// After a start on the move. The first standstill must be certain: the wheel does not turn, and the
// IMU is steady and vibrates much less than while driving; or the robot stands by the rules for an
// engine.
void MotionJudge::learn_rest(TimeNs to, bool with_engine) {
  const TimeNs from = to - kSecond;
  if (!wheel_.distance(from) || !wheel_.distance(to)) return;
  const bool wheel_stood =
      rolled(std::min(from, to - wheel_tick_.longest()), to) <= 2 * config_.wheel.noise_floor;
  const auto samples = imu_.between(from, to);
  if (samples.size() < 4 || (!wheel_stood && !with_engine)) return;
  const ImuNoise noise = measured_noise(samples);
  const bool shows =
      rest_.known() || (vibration_.far_below_driving(noise) && is_steady(samples, noise));
  if (shows || with_engine)
    rest_.stood(samples, wheel_stood ? 0.0 : wheel_.path(from, to) / to_seconds(kSecond));
}

void MotionJudge::learn_vibration(TimeNs from, TimeNs to) {
  constexpr double kTurns_mps = 0.05;
  if (rolled(from, to) < kTurns_mps * to_seconds(to - from)) return;
  const auto samples = imu_.between(from, to);
  if (samples.size() >= 4) vibration_.drives(measured_noise(samples));
}

StateInput MotionJudge::judge(TimeNs to) {
  const TimeNs from = std::exchange(judged_to_, to);
  StateInput input;
  input.time = to;
  input.steps = imu_.steps(from, to);
  const TimeNs margin = state_period_ / 2;  // more samples for the same noise
  input.noise = noise(from - margin, to + margin);
  input.noise.accel_density =
      std::hypot(input.noise.accel_density, slip_belief_.axes_error(input.steps));
  // If IMU and wheel are both silent, the length of the path is known, but not its course.
  const bool across_gaps = imu_silent(imu_.steps(from - state_period_, to));
  input.has_wheel = set_wheel_distances(input.steps, wheel_, from, across_gaps);
  turn_rate_.complete(
      input, from, newest_.state.gyro_bias, imu_,
      std::hypot(config_.wheel.noise_floor, rest_.wheel_mps() * to_seconds(to - from)));

  SlipModel slip = slip_model(config_.wheel);
  slip.share = slip_share();
  if (config_.wheel.form == WheelForm::kIncrement)  // the paper has no such thing
    wheel_gap_.complete(input, from, wheel_, slip);
  input.axes_known = axes_known_;
  input.wheel_y_m = slip_belief_.position().believed_m();
  slip_.set_wheel_position(input.wheel_y_m);
  input.wheel_sigma_m = drive_noise_.increment_sigma();
  input.wheel_floor_m = config_.wheel.noise_floor;
  const double delay_s = wheel_delay_s();
  input.wheel_late = delay_s > 0.5 * to_seconds(state_period_);
  input.wheel_delay_s = delay_s;
  slip_.set_wheel_error({pair_.middle_noise(), input.wheel_sigma_m, input.wheel_floor_m,
                         std::max(wheel_.held_s(), delay_s)});
  learn_vibration(from - margin, to + margin);
  if (!rest_.known()) learn_rest(to, false);

  input.speed_correction = slip_.take_speed_correction(from, wheel_, newest_.state.wheel_scale);
  if (pair_slip_.knows(to)) input.speed_correction.reset();  // the speed is measured
  if (input.speed_correction) speed_known_after_ = to + lag_;
  forget_old_standing();
  AtRest known = at_rest();
  known.wheel_hides =
      wheel_tick_.hides_motion(newest_, imu_.between(from, to), rest_.noise().accel_density, to);
  StandstillVerdict verdict =
      judge_standstill(config_, known, imu_, wheel_, radar_standing_, from, to);
  const bool with_engine =
      !verdict.standing && !verdict.steady_rate && !known.wheel_hides && stands_with_engine(to);
  verdict.standing |= with_engine;
  if (verdict.standing) learn_rest(to, with_engine);
  input.gyro_bias = bias_watch_.new_bias(verdict, newest_.state.gyro_bias, to_seconds(to - from));
  input.standing = verdict.standing || input.gyro_bias.has_value();
  input.wheel_contradicted = verdict.wheel_contradicted || slip_.between(from, to);
  if (pair_.received()) pair_.complete(input, from, newest_.state, wheel_, slip_.ground(from, to));
  const bool immobilised = immobilised_.at(to, wheel_) == Immobilised::kYes;
  input.wheel_contradicted |= immobilised;
  if (!input.standing && axes_known_) drive_noise_.add(input, newest_.state);
  if (!input.has_wheel || input.wheel_contradicted) no_wheel_until_ = to;
  follow_slip(input);
  input.displacements = take_displacements(to);
  input.passages = pair_slip_.take_passages(to);
  if (immobilised && !input.standing) input.displacements.emplace_back(no_displacement(from, to));
  return input;
}

// Of an immobilised robot that its wheels shake: the IMU does not see the standstill, only the
// radar.
Displacement MotionJudge::no_displacement(TimeNs from, TimeNs to) const {
  Displacement none;
  none.time = none.to = to;
  none.from = from;
  none.source = "immobilised";
  none.kind = DisplacementKind::kSequential;
  none.valid = true;
  none.sigma_m = StandstillSigmas().position;
  return none;
}

// A displacement may arrive before the state at its end, which waits for the reorder window.
std::vector<PlacedDisplacement> MotionJudge::take_displacements(TimeNs to) {
  std::vector<PlacedDisplacement> taken;
  for (Waiting& waiting : take_ended(displacements_, to))
    if (enters_estimate(waiting)) taken.push_back(std::move(waiting));
  return taken;
}

// By accelerations, and by the passages of two antennas in a row where they tell of it.
void MotionJudge::follow_slip(StateInput& input) {
  compare_with_wheel();
  if (axes_known_)
    slip_belief_.advance(input, newest_, rest_.noise(), drive_noise_.accel_density_of_one_second());
  input.slips = pair_slip_.revise(slip_belief_.recent(), input.time);
  newest_slip_ = input.slips.empty() ? IntervalSlip{} : input.slips.back();
}

// The coherence is learnt from the wheel, so it adds nothing while the wheel can be used.
bool MotionJudge::enters_estimate(const Waiting& waiting) const {
  if (!waiting.by_coherence) return true;
  const CoherenceUse use = config_.gpr.coherence.use;
  return use == CoherenceUse::kAlways ||
         (use == CoherenceUse::kContradicted && waiting.from < no_wheel_until_);
}

void MotionJudge::forget_old_standing() {
  const TimeNs old = imu_now_ - kStandingKept;
  radar_standing_.erase(std::remove_if(radar_standing_.begin(), radar_standing_.end(),
                                       [old](const gpr::Standstill& s) { return s.to < old; }),
                        radar_standing_.end());
}

bool MotionJudge::follow(OdometryEstimate& estimate) {
  // After a gap of the IMU the speed is predicted or the wheel's own, so it cannot show slip.
  if (newest_.carried) speed_known_after_ = newest_.state.time + lag_;
  const bool speed_known = estimate.time > speed_known_after_;
  const bool slipped = slip_.now() != WheelSlip::kNone;
  if (!newest_.bridged && axes_known_) slip_.add(estimate, wheel_, wheel_now_, speed_known);
  estimate.flags = flags();
  coherence_.add(estimate, speed_known);
  sight_.add(estimate, speed_known);
  return !slipped && slip_.now() != WheelSlip::kNone;
}

Eigen::Vector3d MotionJudge::wheel_contact() const {
  Eigen::Vector3d contact = config_.wheel.lever_arm;
  contact.y() = slip_belief_.position().believed_m();
  return contact;
}

std::optional<WheelWaySince> MotionJudge::wheel_since(TimeNs state, const PredictedWay& way,
                                                      TimeNs heard) const {
  const WheelConfig& c = config_.wheel;
  if (!c.enabled || newest_.standing || newest_.bridged || newest_.carried) return {};
  const auto begin = wheel_.distance(state), end = wheel_.distance(way.time);
  const bool tells = begin && end && wheel_delay_s() <= 0 &&
                     immobilised_.at(way.time, wheel_) != Immobilised::kYes &&
                     !slip_.between(state, way.time, heard);
  // As the window takes it: its slip goes on.
  const double moved_m = tells ? (*end - *begin) * std::exp(newest_slip_.l) : way.moved_m.x(),
               path_m = std::abs(moved_m);
  const auto sigma_of = [&c, path_m](double noise) {
    return std::sqrt(noise * noise * path_m + c.noise_floor * c.noise_floor);
  };
  Eigen::Vector3d sigma_m(sigma_of(c.noise), sigma_of(c.lateral_noise), sigma_of(c.vertical_noise));
  sigma_m.x() = tells ? std::hypot(std::max(sigma_m.x(), drive_noise_.increment_sigma()),
                                   newest_slip_.sigma * moved_m)
                      : kUnknownDistanceSigma_m;
  const double speed = path_m / to_seconds(way.time - state);
  sigma_m.y() = std::hypot(sigma_m.y(), side_slip(drive_traits(c), way.turned_rad, speed));
  if (c.form == WheelForm::kDistance) sigma_m.tail<2>().setConstant(kUnknownDistanceSigma_m);
  return WheelWaySince{{moved_m, 0, 0}, sigma_m};
}

std::int32_t MotionJudge::flags() const {
  std::int32_t flags = 0;
  if (newest_.standing) flags |= kStanding;
  if (slip_.now() == WheelSlip::kFast) flags |= kSlipping | kWheelFast;
  if (slip_.now() == WheelSlip::kSlow) flags |= kSlipping | kWheelSlow;
  if (pair_.slipping() == SlippingSide::kLeft) flags |= kLeftSlips;
  if (pair_.slipping() == SlippingSide::kRight) flags |= kRightSlips;
  if (immobilised_.at(wheel_now_, wheel_) == Immobilised::kYes) flags |= kImmobilised;
  if (newest_.no_wheel) flags |= kNoWheel;
  if (newest_.bridged) flags |= kImuGap;
  if (!newest_.solve.usable) flags |= kSolverFailed;
  return flags;
}

}  // namespace gprodom
