#include "motion/immobilised.h"

#include <algorithm>
#include <cmath>

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

// The recent way, and the prior of its blind share: 1 m of which 1 % is blind.
constexpr double kRecent_m = 20.0, kPrior_m = 1.0, kPriorBlind = 0.01;
constexpr double kMostBlind = 0.02, kLeastSeen_m = 1.0;
constexpr double kSeesMotion = 2.0;  // times the least travel that the radar sees

// How long before the standstill the IMU is asked from: braking takes that long.
constexpr TimeNs kBefore = 2 * kSecond;
constexpr double kMostOdds = 6.0;  // of the log odds by the IMU, whose noise is not known so well
// Log odds by the IMU with which the ground need not be known; with which it is not believed.
constexpr double kByImuAlone = 3.0, kAgainst = -2.0;

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
  if (way < kTurns_mps * to_seconds(sight.to - sight.from)) return;
  if (now_ == Immobilised::kYes && sight.to <= told_at_ + kHolds) return;
  seen_.push_back({sight.from, sight.to, way, way / sight.times_least});
  seen_m_ += way;
  while (seen_m_ > kRecent_m) {
    seen_m_ -= seen_.front().way_m;
    seen_.pop_front();
  }
}

// Of the way before a time: what a standstill has made blind says nothing of the ground before it.
ImmobilisedWatch::Share ImmobilisedWatch::blind_share(TimeNs before, double travel_m) const {
  double blind = kPrior_m * kPriorBlind, all = kPrior_m;
  for (const Seen& s : seen_) {
    if (s.to > before) break;
    all += s.way_m;
    if (kSeesMotion * s.least_m > travel_m) blind += s.way_m;
  }
  return {blind / all, all - kPrior_m};
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
  const Known* from = reference(since, turns);
  const double by_imu = from ? log_odds_by_imu(*from, to, speed, imu, accel_density) : 0.0;
  const Share recent = blind_share(since, std::abs(*after - *before));
  const bool sees = recent.way_m >= kLeastSeen_m && recent.blind < kMostBlind;
  const bool stays = at(to, wheel) == Immobilised::kYes;
  const bool yes = by_imu > kByImuAlone || ((sees || stays) && by_imu > kAgainst);
  now_ = yes ? Immobilised::kYes : Immobilised::kCannotTell;
  told_at_ = to;
  if (!yes) return;
  while (!seen_.empty() && seen_.back().to > since) {
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
  double speed = from.speed, dt = 0.0;
  for (const MotionStep& step : imu.steps(from.time, to, kSecond / 10)) {
    if (step.bridged) return 0.0;
    const Vector3d phi = (step.angular_velocity - from.gyro_bias) * step.dt;
    const Vector3d force = q * so3::exp(0.5 * phi) * (step.acceleration - from.accel_bias);
    q = (q * so3::exp(phi)).normalized();
    const Vector3d forwards = (q * Vector3d::UnitX()).normalized();
    speed += (force - gravity_ * Vector3d::UnitZ()).dot(forwards) * step.dt;
    dt += step.dt;
  }
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
  return rests || now > told_at_ + kHolds ? Immobilised::kNo : now_;
}

}  // namespace gprodom
