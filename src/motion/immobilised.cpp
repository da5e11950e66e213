#include "motion/immobilised.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/so3.h"

namespace gprodom {

using Eigen::Vector3d;

namespace {

constexpr TimeNs kSecond = 1'000'000'000;

// Asked is 0.3 m of wheel travel, or a second at 0.3 m/s and more. The more of it passes, the surer
// it is; the radar is half a second behind.
constexpr double kAsked_m = 0.25, kBehind_s = 0.6, kLeastTravel_m = 0.1, kMostTravel_m = 0.15;
constexpr TimeNs kLongest = 7 * kSecond;  // that it is counted over, as long as wheel data are kept
constexpr double kBegins_m = 0.01;  // of wheel travel, with which a wheel at rest begins to turn
constexpr TimeNs kJustNow = kSecond / 2;  // of the wheel's speed, at the end of a standstill
constexpr double kTurns_mps = 0.01;       // a wheel that is slower rests
constexpr double kMostTurning = 0.1;      // rad/s; beyond, the robot turns on the spot
constexpr TimeNs kHolds = kSecond;        // after the last standstill, which come every gpr.tick

// Share of the way on which the radar is blind: over the recent way, with a prior of 1 m of which 1
// % is blind. Against it stands the share on which the robot is immobilised: more than it will be,
// since a robot that is stuck and not told so is the worse of the two errors.
constexpr double kRecent_m = 100.0, kPrior_m = 1.0, kPriorBlind = 0.01;
constexpr double kImmobilisedShare = 5e-3;
constexpr double kSeesMotion = 2.0;  // times the least travel that the radar sees
constexpr double kBlind_m = 1.0;     // of way, that a flag which proved wrong adds

// How long before the standstill the IMU is asked from: braking takes that long.
constexpr TimeNs kBefore = 2 * kSecond;
constexpr TimeNs kShort = 3 * kSecond;  // of ground that looks alike; a robot is stuck for longer
constexpr TimeNs kOnset = kSecond;      // and for how long after the wheel turns alone
constexpr double kMostOdds = 6.0;  // of the log odds by the IMU, whose noise is not known so well

}  // namespace

void ImmobilisedWatch::add(const StateResult& result) {
  const NavState& x = result.state;
  Known known;
  known.time = x.time;
  known.q = x.q_odom_body;
  known.gyro_bias = x.gyro_bias;
  known.accel_bias = x.accel_bias;
  known.standing = result.standing;
  const Vector3d forwards = x.q_odom_body * Vector3d::UnitX();
  known.speed = forwards.dot(x.v_odom);
  Eigen::Matrix<double, 2, kStateDim> J;
  J.setZero();
  J.block<1, 3>(0, row::kV) = forwards.transpose();
  // A pitch that is wrong lets gravity into the acceleration along the track.
  J.block<1, 3>(1, row::kTheta) = gravity_ * Vector3d::UnitZ().cross(forwards).transpose();
  J.block<1, 3>(1, row::kBa) = Vector3d::UnitX().transpose();
  const Eigen::Matrix2d variance = J * result.covariance * J.transpose();
  known.speed_variance = variance(0, 0);
  known.accel_error_variance = variance(1, 1);
  if (!states_.empty() && x.time <= states_.back().time) states_.clear();
  states_.push_back(known);
  while (states_.front().time < x.time - kMemory) states_.pop_front();
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
  // It rolls again, and the wheel has not stopped meanwhile: it had rolled all the time.
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

// Of the way before a time: what a standstill has made blind says nothing of the ground before it.
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
  // The IMU is asked of the beginning, however long the standstill has been: its errors grow.
  const TimeNs end = std::min(to, turns + kOnset);
  const auto end_m = wheel.distance(end), earlier_m = wheel.distance(end - kJustNow);
  const Known* from = reference(since, turns);
  double by_imu = 0.0;
  if (from && end_m && earlier_m) {
    const double rolls_mps = (*end_m - *earlier_m) / scale / to_seconds(kJustNow);
    by_imu = log_odds_by_imu(*from, end, rolls_mps, imu, accel_density);
  }
  // From an onset longer ago than that, the IMU cannot tell any more.
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

// Of a state whose speed is known without this standstill: before the robot may have braked for it;
// or at rest, before the wheel turned.
const ImmobilisedWatch::Known* ImmobilisedWatch::reference(TimeNs since, TimeNs wheel_turns) const {
  const auto state = std::find_if(states_.rbegin(), states_.rend(), [&](const Known& k) {
    return k.time <= since - kBefore || (k.standing && k.time <= wheel_turns);
  });
  return state == states_.rend() ? nullptr : &*state;
}

// ln p(IMU | it stands) / p(IMU | it rolls as the wheel says) at `to`.
double ImmobilisedWatch::log_odds_by_imu(const Known& from, TimeNs to, double wheel_mps,
                                         const ImuHistory& imu, double accel_density) const {
  Eigen::Quaterniond q = from.q;
  // Compared is the mean over the last half second.
  const double whole = to_seconds(to - from.time);
  double speed = from.speed, dt = 0.0, mean = 0.0, over = 0.0;
  for (const MotionStep& step : imu.steps(from.time, to, kSecond / 10)) {
    if (step.bridged) return 0.0;
    const Vector3d phi = (step.angular_velocity - from.gyro_bias) * step.dt;
    const Vector3d force = q * so3::exp(0.5 * phi) * (step.acceleration - from.accel_bias);
    q = (q * so3::exp(phi)).normalized();
    const Vector3d forwards = (q * Vector3d::UnitX()).normalized();
    speed += (force - gravity_ * Vector3d::UnitZ()).dot(forwards) * step.dt;
    dt += step.dt;
    if (dt > whole - to_seconds(kJustNow)) {
      mean += speed * step.dt;
      over += step.dt;
    }
  }
  if (over <= 0) return 0.0;
  speed = mean / over;
  const double variance = from.speed_variance + accel_density * accel_density * dt +
                          from.accel_error_variance * dt * dt;
  const double rolls = speed - wheel_mps;
  return std::clamp((rolls * rolls - speed * speed) / (2 * variance), -kMostOdds, kMostOdds);
}

Immobilised ImmobilisedWatch::at(TimeNs now, const WheelHistory& wheel) const {
  if (now_ == Immobilised::kNo) return now_;
  const auto before = wheel.distance(now - kJustNow), after = wheel.distance(now);
  const bool rests =
      before && after && std::abs(*after - *before) < kTurns_mps * to_seconds(kJustNow);
  return rests || now > detected_to_ + kHolds ? Immobilised::kNo : now_;
}

}  // namespace gprodom
