// The start of the estimator: at rest, from a short stop, or on the move.
#include <algorithm>
#include <cmath>

#include "estimation/revised_state.h"
#include "motion/gyro_bias_size.h"
#include "motion/motion_judge.h"
#include "motion/slip/slip_block.h"

namespace gprodom {

namespace {

// The robot starts on the move after this time without a standstill, if the wheel has turned this
// far in initializer.duration.
constexpr TimeNs kStartOnTheMove = 4 * kSecond;
constexpr double kMoving_m = 0.1;
// It waits for a wheel that does not slip, and until the size of the gyro's bias shows, but not for
// longer than this.
constexpr TimeNs kStartAnyway = 9 * kSecond;

// A start from a stop of less than initializer.duration: so much of it is enough. The wheel turns
// by no more within it, of which all may be the end of the braking: it begins so much later.
constexpr double kShareOfShortStop = 0.5, kStill_m = 1e-3;
constexpr TimeNs kBrakes = kSecond / 5;

// From `from` to `to`, as far as there are data.
WheelSpeeds speeds(const WheelHistory& wheel, TimeNs from, TimeNs to) {
  WheelSpeeds result{from, {}};
  const TimeNs part = from_seconds(WheelSpeeds::kPart);
  for (TimeNs t = from; t + part <= to; t += part) {
    const auto a = wheel.distance(t), b = wheel.distance(t + part);
    if (!a || !b) {
      if (!result.mps.empty()) break;
      result.from = t + part;  // the wheel's data begin later
      continue;
    }
    result.mps.push_back((*b - *a) / WheelSpeeds::kPart);
  }
  return result;
}

}  // namespace

Initialization MotionJudge::initialize(bool has_begun) {
  const TimeNs from = imu_now_ - from_seconds(config_.initializer.duration);
  const TimeNs driven_from = imu_now_ - kStartOnTheMove;
  const TimeNs since = std::max(first_imu_, imu_now_ - kStartAnyway);
  imu_.forget_before(std::min(from, since));
  Initialization found = initialize_at_rest(from, 1.0);
  if (found.initial) return found;
  // The robot may stand for less long than that, or have only just stopped.
  const TimeNs still = wheel_.still_since(from, 2 * config_.wheel.noise_floor + kStill_m);
  if (still > from) {
    Initialization short_stop = initialize_at_rest(still + kBrakes, kShareOfShortStop);
    if (short_stop.initial) return short_stop;
  }
  WheelAtStart wheel = wheel_at_start(from);
  if (imu_now_ - first_imu_ > kStartOnTheMove && wheel.path_m > kMoving_m) {
    const TimeNs wheel_to = std::min(imu_now_, wheel_now_);
    const bool soon = imu_now_ - first_imu_ < kStartAnyway, waits = soon && !has_begun;
    wheel.agrees =
        speeds_agree(imu_.between(driven_from, imu_now_), speeds(wheel_, driven_from, wheel_to));
    if (!wheel.agrees && waits)
      return {std::nullopt, "on the move, and the wheel disagrees with the accelerations"};
    std::optional<ImuBias> bias = bias_at_begin(since);
    if (!bias) {
      const GyroBiasSize size =
          gyro_bias_size(imu_.between(since, imu_now_), speeds(wheel_, since, wheel_to));
      if (!size.known && waits)
        return {std::nullopt, "on the move, and the gyro's bias does not show yet"};
      bias = ImuBias();
      bias->gyro_sigma = size.sigma;
    }
    const double accel_scale = soon ? 1.0 : accel_scale_on_the_move(imu_.between(since, imu_now_));
    Initialization moving = initialize_moving(config_, imu_.between(from, imu_now_), wheel, *bias,
                                              accel_scale, has_begun);
    if (moving.initial) divide_forces(accel_scale);
    if (moving.initial) return moving;
  }
  return found;
}

// Of a robot that stood for a moment before it drove off: too short to start from.
std::optional<ImuBias> MotionJudge::bias_at_begin(TimeNs since) const {
  const auto [from, to] = wheel_.still_from(since, 2 * config_.wheel.noise_floor + kStill_m);
  if (to - kBrakes <= from) return std::nullopt;
  WheelAtStart stood;
  stood.received = true;
  const Initialization at_rest =
      gprodom::initialize(config_, imu_.between(from, to - kBrakes), stood, kShareOfShortStop);
  if (!at_rest.initial) return std::nullopt;
  const Eigen::MatrixXd& A = at_rest.initial->prior.A;
  return ImuBias{at_rest.initial->state.gyro_bias, 1 / A.col(row::kBg).norm(),
                 at_rest.initial->state.accel_bias};
}

std::optional<Eigen::Vector3d> MotionJudge::mean_force() const {
  const auto samples =
      imu_.between(imu_now_ - from_seconds(config_.initializer.duration), imu_now_);
  if (samples.empty()) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) sum += sample.acceleration;
  return sum / static_cast<double>(samples.size());
}

void MotionJudge::turn_axes(const Eigen::Matrix3d& R_new_old) {
  imu_.turn(R_new_old);
  const CarriedState turned = with_turned_axes({newest_.state, newest_.covariance}, R_new_old);
  newest_.state = turned.state;
  newest_.covariance = turned.covariance;
  slip_belief_.restart();
}

// m/s^2, root mean square: what a horizontal acceleration errs by if its direction is not known.
double MotionJudge::error_of_unknown_axes(const std::vector<MotionStep>& steps) const {
  const slip::LevelMotion motion(steps, newest_.state.q_odom_body, newest_.state.gyro_bias);
  return motion.dt > 0 ? std::sqrt(2.0) * motion.mean_acceleration().norm() : 0.0;
}

Initialization MotionJudge::initialize_at_rest(TimeNs from, double share) {
  const WheelAtStart wheel = wheel_at_start(from);
  Initialization found = gprodom::initialize(config_, imu_.between(from, imu_now_), wheel, share);
  if (!found.initial) return found;
  divide_forces(found.initial->accel_scale);
  const auto samples = imu_.between(from, imu_now_);
  rest_.measure(samples, wheel.path_m / to_seconds(samples.back().time - samples.front().time));
  return found;
}

WheelAtStart MotionJudge::wheel_at_start(TimeNs from) const {
  const TimeNs over = from_seconds(WheelAtStart::kSpeedOver), to = std::min(imu_now_, wheel_now_);
  const auto speed_since = [&](TimeNs since) {
    const auto a = wheel_.distance(since), b = wheel_.distance(since + over);
    return a && b ? (*b - *a) / WheelAtStart::kSpeedOver : 0.0;
  };
  const bool received = wheel_now_ > from && config_.wheel.enabled;
  return {received, wheel_.path(from, imu_now_), speed_since(from), speed_since(to - over)};
}

}  // namespace gprodom
