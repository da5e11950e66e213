#include "motion/immobilised.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/increments/imu_preintegration.h"
#include "estimation/predict.h"

namespace gprodom {

using Eigen::Vector3d;

namespace {

// Travel of the wheel that a flag needs. The flag must come within 0.3 m, and within a second from
// 0.3 m/s on; the radar's answer comes kBehind_s late. The longer travel is the surer one.
constexpr double kAsked_m = 0.25, kBehind_s = 0.6, kLeastTravel_m = 0.1, kMostTravel_m = 0.15;
constexpr TimeNs kLongest = 7 * kSecond;  // of that travel; wheel data are kept for 8 s
constexpr double kBegins_m = 0.01;        // travel with which a wheel at rest begins to turn
constexpr TimeNs kJustNow = kSecond / 2;  // over which speeds are means
constexpr double kTurns_mps = 0.01;       // below, the wheel rests
constexpr double kMostTurning = 0.1;      // rad/s; above, the robot turns on the spot
constexpr TimeNs kHolds = kSecond;        // after the last standstill; one comes every gpr.tick

// Share of the path on which the radar is blind: a prior of 1 m with 1 %, and the recent path. The
// share on which a robot is immobilised stands against it. It is set high, since a stuck robot that
// is not reported is the worse error.
constexpr double kRecent_m = 100.0, kPrior_m = 1.0, kPriorBlind = 0.01;
constexpr double kImmobilisedShare = 5e-3;
constexpr double kSeesMotion = 2.0;  // times the least travel that the radar sees
constexpr double kBlind_m = 1.0;     // blind path that a wrong flag adds
// A flag that ends sooner than this, while the wheel turns, was wrong: a stuck robot is stuck
// longer.
constexpr TimeNs kShort = 3 * kSecond;

// The IMU's change of speed is taken from kBefore the standstill, since the robot brakes before it,
// to kOnset after its begin.
constexpr TimeNs kBefore = 2 * kSecond, kOnset = kSecond;
constexpr double kSlips = 0.3;  // prior of a wheel that rolls: the default of wheel.slip_share
// Density that the IMU is wrong altogether: its noise is not known so well. Bounds the log odds
// at 6.
constexpr double kImuWrong = 2.5e-3;

double forward_speed(const NavState& x) {
  return (x.q_odom_body * Vector3d::UnitX()).dot(x.v_odom);
}

}  // namespace

void ImmobilisedWatch::add(const StateResult& result) {
  const NavState& x = result.state;
  const Vector3d forwards = x.q_odom_body * Vector3d::UnitX();
  Eigen::Matrix<double, 2, kStateDim> J;
  J.setZero();
  J.block<1, 3>(0, row::kV) = forwards.transpose();
  // With a wrong pitch, gravity has a component along the track.
  J.block<1, 3>(1, row::kTheta) = kStandardGravity * Vector3d::UnitZ().cross(forwards).transpose();
  J.block<1, 3>(1, row::kBa) = Vector3d::UnitX().transpose();
  const Eigen::Matrix2d variance = J * result.covariance * J.transpose();
  if (!states_.empty() && x.time <= states_.back().state.time) states_.clear();
  states_.push_back({x, variance(0, 0), variance(1, 1), result.standing});
  while (states_.front().state.time < x.time - kMemory) states_.pop_front();
}

void ImmobilisedWatch::add(const gpr::Sight& sight, double wheel_m) {
  const double way = std::abs(wheel_m);
  const bool yes = now_ == Immobilised::kYes;
  if (way < kTurns_mps * to_seconds(sight.to - sight.from)) {
    if (yes && sight.from > detected_to_) now_ = Immobilised::kNo;
    return;
  }
  Seen seen{sight.from, sight.to, way, way / sight.times_least};
  const bool over = sight.to > detected_to_ + kHolds;
  if (yes && !over && (sight.from < detected_to_ || sight.times_least < kSeesMotion)) return;
  // The radar sees motion again although the wheel has not stopped: the robot has rolled all along.
  if (yes && detected_to_ - detected_since_ < kShort)
    seen = {detected_since_, sight.to, kBlind_m, std::numeric_limits<double>::infinity()};
  if (yes) now_ = Immobilised::kNo;
  seen_.push_back(seen);
  seen_m_ += seen.way_m;
  while (seen_m_ > kRecent_m) {
    seen_m_ -= seen_.front().way_m;
    seen_.pop_front();
  }
}

// Over the path before a time, since this standstill says nothing of the ground before it.
double ImmobilisedWatch::blind_share(TimeNs before, double travel_m) const {
  double blind = kPrior_m * kPriorBlind, all = kPrior_m;
  for (const Seen& s : seen_) {
    if (s.to > before) break;
    all += s.way_m;
    if (kSeesMotion * s.least_m > travel_m) blind += s.way_m;
  }
  return blind / all;
}

void ImmobilisedWatch::add(const gpr::Standstill& standstill, const WheelHistory& wheel,
                           const ImuHistory& imu, double scale, double accel_density) {
  const TimeNs to = standstill.to;
  const TimeNs compared = standstill.since > 0 ? standstill.since : standstill.from;
  const TimeNs since = std::max(compared, to - kLongest);
  const auto before = wheel.distance(since), just_now = wheel.distance(to - kJustNow),
             after = wheel.distance(to);
  if (!before || !just_now || !after) return;
  const double speed = (*after - *just_now) / scale / to_seconds(kJustNow);
  const double needed =
      std::clamp(kAsked_m - kBehind_s * std::abs(speed), kLeastTravel_m, kMostTravel_m);
  if (std::abs(speed) < kTurns_mps || std::abs(*after - *before) < needed * scale) {
    if (now_ == Immobilised::kCannotTell) now_ = Immobilised::kNo;
    return;
  }
  double turned = 0.0;
  for (const MotionStep& step : imu.steps(to - kJustNow, to, kSecond))
    turned += step.angular_velocity.z() * step.dt;
  if (std::abs(turned) > kMostTurning * to_seconds(kJustNow)) return;

  TimeNs turns = since;
  while (turns < to && std::abs(wheel.distance(turns).value_or(*before) - *before) < kBegins_m)
    turns += kSecond / 10;
  // Only the beginning of the standstill counts: the errors of the integrated IMU grow with time.
  const TimeNs end = std::min(to, turns + kOnset);
  const auto end_m = wheel.distance(end), earlier_m = wheel.distance(end - kJustNow);
  // A state within the standstill is at rest for another reason only if the wheel rested too.
  const bool rested = turns - since >= kJustNow;
  const Known* from = reference(since, rested ? turns : since - kBefore);
  double by_imu = 0.0;
  if (from && end_m && earlier_m) {
    const double rolls_mps = (*end_m - *earlier_m) / scale / to_seconds(kJustNow);
    by_imu = log_odds_by_imu(*from, end, rolls_mps, imu, accel_density);
  }
  // The standstill began before the data that are kept, so the IMU cannot confirm it.
  if (compared < since) by_imu = std::min(by_imu, 0.0);
  const bool stays = at(to, wheel) == Immobilised::kYes;
  const bool yes =
      stays || by_imu > std::log(blind_share(since, needed * scale) / kImmobilisedShare);
  if (yes && !stays) detected_since_ = since;
  now_ = yes ? Immobilised::kYes : Immobilised::kCannotTell;
  detected_to_ = to;
  if (yes) forget_after(since);
}

void ImmobilisedWatch::forget_after(TimeNs time) {
  while (!seen_.empty() && seen_.back().to > time) {
    seen_m_ -= seen_.back().way_m;
    seen_.pop_back();
  }
}

// The newest state whose speed does not depend on this standstill: from before the robot can have
// braked for it, or at rest before the wheel turned.
const ImmobilisedWatch::Known* ImmobilisedWatch::reference(TimeNs since, TimeNs wheel_turns) const {
  const auto state = std::find_if(states_.rbegin(), states_.rend(), [&](const Known& k) {
    return k.state.time <= since - kBefore || (k.standing && k.state.time <= wheel_turns);
  });
  return state == states_.rend() ? nullptr : &*state;
}

// ln p(IMU | it stands) / p(IMU | it rolls), with a speed between 0 and the wheel's if the wheel
// slips. wheel_mps: mean over the kJustNow before `to`; the IMU gives the speed at the middle of
// that time.
double ImmobilisedWatch::log_odds_by_imu(const Known& from, TimeNs to, double wheel_mps,
                                         const ImuHistory& imu, double accel_density) const {
  ImuPreintegration moved(ImuNoise{}, from.state.gyro_bias, from.state.accel_bias);
  for (const MotionStep& step : imu.steps(from.state.time, to - kJustNow / 2)) {
    if (step.bridged) return 0.0;
    moved.integrate(step.acceleration, step.angular_velocity, step.dt);
  }
  const double speed = forward_speed(propagate(from.state, moved, kStandardGravity));
  const double seconds = moved.duration();
  const double variance = from.speed_variance + accel_density * accel_density * seconds +
                          from.accel_error_variance * seconds * seconds;
  const double sigma = std::sqrt(variance);
  const double wheel = std::max(std::abs(wheel_mps) / sigma, 1e-3);
  const double along = std::copysign(speed, speed * wheel_mps) / sigma;
  // Densities over that at the peak; for a wheel that slips, the mean over its speeds.
  const double stands = std::exp(-0.5 * along * along);
  const double grips = std::exp(-0.5 * (along - wheel) * (along - wheel));
  const double slips = std::sqrt(M_PI / 2) / wheel *
                       (std::erf((wheel - along) / M_SQRT2) + std::erf(along / M_SQRT2));
  const double rolls = (1 - kSlips) * grips + kSlips * slips;
  return std::log((stands + kImuWrong) / (rolls + kImuWrong));
}

Immobilised ImmobilisedWatch::at(TimeNs now, const WheelHistory& wheel) const {
  if (now_ == Immobilised::kNo) return now_;
  const auto before = wheel.distance(now - kJustNow), after = wheel.distance(now);
  const bool rests =
      before && after && std::abs(*after - *before) < kTurns_mps * to_seconds(kJustNow);
  return rests || now > detected_to_ + kHolds ? Immobilised::kNo : now_;
}

}  // namespace gprodom
