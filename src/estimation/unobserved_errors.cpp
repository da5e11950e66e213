#include "estimation/unobserved_errors.h"

#include <cmath>
#include <utility>

namespace gprodom {

using Eigen::Vector3d;

namespace {

// Of driving, after which accelerations must have shown the wheel's scale. By then their noise on
// the move is known, and a start or a stop has been seen.
constexpr double kScaleTrial_s = 20.0;

// Gravity shows that the scale of the accelerometer may be wrong, too: a wheel's scale learnt from
// accelerations would have the same error.
bool out_of_calibration(const InitialState& initial) {
  return initial.state.accel_bias.norm() > kOutOfCalibration || initial.accel_scale != 1.0;
}

}  // namespace

HeldScale::HeldScale(const WheelConfig& config, const InitialState& initial)
    : may_be_shown_(config.scale_sigma > 0),
      held_(may_be_shown_ && out_of_calibration(initial)),
      first_(initial.state.wheel_scale),
      first_sigma_(std::sqrt(initial.prior.covariance()(row::kScale, row::kScale))),
      start_(initial.state.p_odom) {}

std::optional<CarriedState> HeldScale::decide(const StateInput& input, const CarriedState& newest) {
  if (!may_be_shown_) return std::nullopt;
  // Along wrong axes accelerations seem to show it as well, wrong by 14 % where the accelerometer
  // has a wrong sign. Once the axes are known they may show it again.
  if (!input.axes_known && !held_) {
    held_without_axes_ = true;
    return held(with_first(newest));
  }
  // So they do of a wheel that is late.
  if (input.wheel_late && !std::exchange(known_late_, true)) {
    held_without_axes_ = false;  // but for good
    if (!held_) return held(newest);
  }
  if (input.axes_known && held_without_axes_) return released(newest);
  if (not_shown(input, newest)) return held(with_first(newest));
  return std::nullopt;
}

// True once, at the end of the trial, if accelerations have told less about the scale than was
// known before. Their errors are coloured: what they have not shown by now, those of a drive many
// times as long do not show either.
bool HeldScale::not_shown(const StateInput& input, const CarriedState& newest) {
  if (held_ || driven_s_ >= kScaleTrial_s) return false;
  if (!input.standing && input.has_wheel && !input.wheel_contradicted)
    driven_s_ += to_seconds(input.time - newest.state.time);
  const double variance = newest.covariance(row::kScale, row::kScale);
  return driven_s_ >= kScaleTrial_s && variance > 0.5 * first_sigma_ * first_sigma_;
}

// Returns to the first value, of which accelerations have shown too little, with the state that
// belongs to it.
CarriedState HeldScale::with_first(CarriedState now) const {
  const StateMatrix before = now.covariance;
  const StateVector gain = before.col(row::kScale) / before(row::kScale, row::kScale);
  now.state = retract(now.state, gain * (first_ - now.state.wheel_scale));
  now.covariance -= gain * before.row(row::kScale);
  return now;
}

CarriedState HeldScale::held(CarriedState now) {
  held_ = true;
  now.state.wheel_scale = first_;
  replace(now.covariance, row::kScale, 1,
          Eigen::MatrixXd::Constant(1, 1, kFixedScaleSigma * kFixedScaleSigma));
  return now;
}

CarriedState HeldScale::released(CarriedState now) {
  held_without_axes_ = held_ = false;
  driven_s_ = 0.0;
  replace(now.covariance, row::kScale, 1, Eigen::MatrixXd::Zero(1, 1));
  now.covariance += covariance_of_first(now.state);
  return now;
}

// A relative error of the scale gives the path since the start, and the speed, the same relative
// error.
StateMatrix HeldScale::covariance_of_first(const NavState& newest) const {
  StateVector share = StateVector::Zero();
  share.segment<3>(row::kP) = (start_ - newest.p_odom) / newest.wheel_scale;
  share.segment<3>(row::kV) = -newest.v_odom / newest.wheel_scale;
  share[row::kScale] = 1;
  return first_sigma_ * first_sigma_ * share * share.transpose();
}

StateMatrix HeldScale::covariance(const NavState& newest) const {
  return held_ ? covariance_of_first(newest) : StateMatrix::Zero();
}

void LastingErrors::add(const StateInput& input, const NavState& before, const NavState& newest) {
  wheel_delay_s_ = input.wheel_delay_s;
  const double seconds = to_seconds(input.time - before.time);
  if (input.standing || !input.has_wheel || input.wheel_contradicted || seconds <= 0) return;
  Vector3d turned = Vector3d::Zero();
  for (const MotionStep& step : input.steps)
    turned += (angular_velocity(step, before.gyro_bias) - before.gyro_bias) * step.dt;
  const double turn = (before.q_odom_body * turned).z();
  const Vector3d aside = Vector3d::UnitZ().cross(newest.p_odom - before.p_odom);
  turned_by_delay_ += aside * turn / seconds;

  // Over which side slip keeps its size. With 1 rad the simulated skid steer's NEES is in its band
  // as well.
  constexpr double kBend = 0.5;  // rad
  const double way = aside.norm();
  if (way <= 0 || std::abs(turn) > kBend) return;
  const double per_rad = side_slip(drive_, 1.0, way / seconds);
  const double more = per_rad * per_rad * std::abs(turn) * (kBend - std::abs(turn));
  side_slip_covariance_ += more * aside * aside.transpose() / (way * way);
}

StateMatrix LastingErrors::covariance(const NavState& newest) const {
  StateMatrix covariance = StateMatrix::Zero();
  const Vector3d late = wheel_delay_s_ * (turned_by_delay_ - newest.v_odom);
  covariance.block<3, 3>(row::kP, row::kP) = side_slip_covariance_ + late * late.transpose();
  return covariance;
}

}  // namespace gprodom
