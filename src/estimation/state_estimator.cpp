#include "estimation/state_estimator.h"

#include <algorithm>
#include <cmath>

#include "estimation/cost_function_factor.h"
#include "estimation/predict.h"
#include "estimation/revised_state.h"

namespace gprodom {

using Eigen::Vector3d;

namespace {

// Random walk, in the solution over all data, in an interval in which the biases have changed by
// more than usual; rad/s, m/s^2. The window begins anew with the biases after the change.
constexpr double kGyroBiasStep = 0.02, kAccelBiasStep = 0.1;

MarginalPrior first_prior(const InitialState& initial, const HeldScale& scale) {
  MarginalPrior prior = initial.prior;
  if (scale.is_held()) prior.add_scale(scale.first(), kFixedScaleSigma);
  return prior;
}

// The motion over an interval. Noise is held over a step, so the errors of velocity and position in
// a single step are fully correlated, and the covariance is singular. A step of more than half of
// the interval is therefore cut in two, each with noise of its own: docs/estimation.md, "IMU
// preintegration".
ImuPreintegration integrated(const StateInput& input, const NavState& last) {
  ImuPreintegration imu(input.noise, last.gyro_bias, last.accel_bias);
  double interval = 0.0;
  for (const MotionStep& step : input.steps) interval += step.dt;
  constexpr double kHalf = 0.5 + 1e-9;  // more than the sum's rounding
  for (const MotionStep& step : input.steps) {
    const ImuNoise& noise = step.bridged ? kBridgedImuNoise : input.noise;
    const int parts = step.dt > kHalf * interval ? 2 : 1;
    for (int part = 0; part < parts; ++part)
      imu.integrate(step.acceleration, angular_velocity(step, last.gyro_bias), step.dt / parts,
                    noise);
  }
  return imu;
}

}  // namespace

StateEstimator::StateEstimator(const Config& config, const InitialState& initial)
    : config_(config),
      drive_(drive_traits(config.wheel)),
      gravity_odom_(0, 0, -kStandardGravity),
      scale_(config.wheel, initial),
      lasting_errors_(config.wheel),
      last_covariance_(first_prior(initial, scale_).covariance()),
      bias_confirmed_(initial.state),
      smoother_(config.smoother.lag, {}, config.smoother.solver, initial.state,
                first_prior(initial, scale_)) {}

StateResult StateEstimator::add(const StateInput& input) {
  take_corrections(input);
  const NavState before = smoother_.newest();  // the solve changes it
  const ImuPreintegration imu = integrated(input, before);
  StateResult result;
  result.bridged = imu_silent(input.steps);
  gap_s_ = result.bridged ? gap_s_ + imu.duration() : 0.0;
  NavState predicted = propagate(before, imu, kStandardGravity);
  predicted.time = input.time;

  update_slips(input.slips);
  update_places(input);
  motion_.add(before.time, input.noise, input.steps);
  const auto b = smoother_.add_state(predicted);
  if (batch_) batch_->add_state(predicted);
  add_motion(input, imu, b);
  add_measurements(input, result);

  if (gap_s_ > kLongestBridge) {
    carry_over(input);
    result.solve.usable = true;
    result.carried = true;
  } else {
    solve(input, b, predicted, result);
    if (input.counted && result.solve.usable) take_count(input);
  }
  result.state = smoother_.newest();
  if (config_.gpr.antennas.size() > 1) result.way = way();
  lasting_errors_.add(input, before, result.state);
  result.covariance =
      last_covariance_ + scale_.covariance(result.state) + lasting_errors_.covariance(result.state);
  if (input.standing) bias_confirmed_ = result.state;
  result.standing = input.standing;
  result.no_wheel = !input.has_wheel;
  return result;
}

CarriedState StateEstimator::now() const { return {smoother_.newest(), last_covariance_}; }

// What the detectors have found wrong in the newest state: the scale cannot be known, or the gyro
// bias or the speed is another.
void StateEstimator::take_corrections(const StateInput& input) {
  if (const auto changed = scale_.decide(input, now())) {
    // In the solution over all data as well, and there for good.
    if (batch_ && scale_.is_held()) batch_->hold_scale(scale_.first());
    continue_from(*changed);
  }
  if (input.turned_axes) continue_from(with_turned_axes(now(), *input.turned_axes));
  if (input.gyro_bias) continue_from(with_gyro_bias(now(), *input.gyro_bias, bias_confirmed_));
  if (input.speed_correction) continue_from(with_speed_correction(now(), *input.speed_correction));
}

// The factors between the new state b and the one before: IMU, walk of biases and scale, standstill
// or wheel.
void StateEstimator::add_motion(const StateInput& input, const ImuPreintegration& imu,
                                FixedLagSmoother::StateId b) {
  const auto a = b - 1;
  const double root_dt = std::sqrt(imu.duration());
  add_factor(a, b, std::make_shared<ImuFactor>(imu, gravity_odom_));
  const double scale_walk = scale_.is_estimated() ? kWheelScaleWalk : 0.0;
  const double gyro_walk = config_.imu.gyro_bias_walk * root_dt,
               accel_walk = config_.imu.accel_bias_walk * root_dt;
  const double scale_step = std::max(scale_walk * root_dt, kFixedScaleSigma);
  const auto walk = std::make_shared<RandomWalkFactor>(gyro_walk, accel_walk, scale_step);
  const auto step = std::make_shared<RandomWalkFactor>(kGyroBiasStep, kAccelBiasStep, scale_step);
  add_factor(a, b, walk, input.gyro_bias || input.turned_axes ? step : walk);
  if (input.standing) {
    add_factor(a, b, std::make_shared<StandstillFactor>(StandstillSigmas{}));
  } else if (config_.wheel.enabled || config_.gpr.antennas.size() > 1) {
    // Changes of speed last for about a second: those of its intervals count once.
    if (!input.has_wheel && input.speed_change > 0)
      add_factor(a, b,
                 std::make_shared<SpeedWalkFactor>(input.speed_change * std::max(1.0, root_dt)));
    add_wheel_factor(input, a, b);  // without a wheel: the robot does not move sideways or upwards
  }
}

// The factors between any earlier states.
void StateEstimator::add_measurements(const StateInput& input, StateResult& result) {
  for (const PlacedDisplacement& d : input.displacements)
    ++(add_displacement(d) ? result.displacements_used : result.displacements_dropped);
  for (const AntennaPassage& p : input.passages)
    ++(add_passage(p) ? result.displacements_used : result.displacements_dropped);
  for (const UserFactor& factor : input.factors) {
    std::string refusal = add_user_factor(factor, result.place_information);
    if (refusal.empty())
      ++result.factors_used;
    else
      result.refused.push_back({factor.name, std::move(refusal)});
  }
}

void StateEstimator::solve(const StateInput& input, FixedLagSmoother::StateId b,
                           const NavState& predicted, StateResult& result) {
  result.solve = smoother_.solve();
  result.solve.usable = result.solve.usable && smoother_.newest().finite();
  if (batch_)  // starting values of the batch solution
    for (auto id = smoother_.oldest_id(); id <= b; ++id)
      batch_->set_state(static_cast<size_t>(id + id_offset_), smoother_.state(id));
  if (result.solve.usable) {
    smoother_.marginalise(input.keep_since);
    motion_.forget_before(smoother_.state(smoother_.oldest_id()).time);
    last_covariance_ = smoother_.newest_covariance() + common_;
    settle(input.keep_since, result);
    if (const auto slip = slip_of(result.settled->time)) result.settled_slip_sigma = slip->sigma;
  } else {
    discard_window(predicted);
  }
}

void StateEstimator::settle(std::optional<TimeNs> keep_since, StateResult& result) {
  const FixedLagSmoother::StateId oldest = smoother_.oldest_id();
  const auto at_age = [&](double seconds) {
    const auto states = std::lround(seconds * config_.smoother.state_rate);
    return std::max(smoother_.newest_id() - states, oldest);
  };
  auto settled = at_age(keep_since ? kSettledWhereMeasured : kSettledAfter);
  if (settled_ && *settled_ >= oldest) {
    result.before_settled = smoother_.state(*settled_);
    settled = std::max(settled, *settled_);
  }
  result.settled = smoother_.state(settled);
  settled_ = settled;
}

void StateEstimator::record() { batch_.emplace(smoother_.newest(), smoother_.prior()); }

bool StateEstimator::add_factor(FixedLagSmoother::StateId a, FixedLagSmoother::StateId b,
                                const std::shared_ptr<const Factor>& factor,
                                const std::shared_ptr<const Factor>& in_batch) {
  if (!smoother_.add_factor(a, b, factor)) return false;
  if (batch_)
    batch_->add_factor(static_cast<size_t>(a + id_offset_), static_cast<size_t>(b + id_offset_),
                       in_batch ? in_batch : factor);
  return true;
}

// The estimates of slip change while their intervals are in the window, since slip shows only after
// seconds.
void StateEstimator::update_slips(const std::vector<IntervalSlip>& slips) {
  const TimeNs oldest = smoother_.state(smoother_.oldest_id()).time;
  while (!slips_.empty() && slips_.front().first <= oldest) slips_.pop_front();
  for (const IntervalSlip& slip : slips) {
    const auto known = std::find_if(slips_.begin(), slips_.end(),
                                    [&](const auto& s) { return s.first == slip.to; });
    if (known == slips_.end()) {
      if (slips_.empty() || slip.to > slips_.back().first)
        slips_.emplace_back(slip.to, std::make_shared<WheelSlipTerm>());
      else
        continue;
    }
    WheelSlipTerm& term = known == slips_.end() ? *slips_.back().second : *known->second;
    term.l = slip.l;
    term.sigma = slip.sigma;
  }
}

// So does the place of the wheel, since bends show it only when much has been turned with a wrong
// one.
void StateEstimator::update_places(const StateInput& input) {
  const TimeNs oldest = smoother_.state(smoother_.oldest_id()).time;
  while (!places_.empty() && places_.front().first <= oldest) places_.pop_front();
  places_.emplace_back(input.time, std::make_shared<WheelPlaceTerm>());
  for (auto& [to, term] : places_) term->y_m = input.wheel_y_m;
}

std::shared_ptr<const WheelSlipTerm> StateEstimator::slip_of(TimeNs time) const {
  for (const auto& [to, term] : slips_)
    if (to == time) return term;
  return nullptr;
}

void StateEstimator::add_wheel_factor(const StateInput& input, FixedLagSmoother::StateId a,
                                      FixedLagSmoother::StateId b) {
  const WheelConfig& c = config_.wheel;
  const bool turns_with_ground = input.has_wheel && !input.wheel_contradicted;
  if (!turns_with_ground && c.form == WheelForm::kDistance) return;
  // A wheel that slips, or has no data, still does not move sideways or upwards. The path for these
  // rows is then predicted with the speed at the beginning.
  const NavState& x = smoother_.state(a);
  const double speed = (x.q_odom_body.conjugate() * x.v_odom).x() * x.wheel_scale;
  WheelIncrement increment(x.gyro_bias);
  double turned = 0.0;
  for (const MotionStep& step : input.steps) {
    const Vector3d rate = angular_velocity(step, x.gyro_bias);
    increment.integrate(rate, step.dt, turns_with_ground ? step.wheel_m : speed * step.dt);
    turned += (rate - x.gyro_bias).z() * step.dt;
  }
  Vector3d variance = increment.variance(
      {c.noise, c.lateral_noise, c.vertical_noise, std::max(c.noise_floor, input.wheel_floor_m)});
  variance[0] = std::max(variance[0], std::pow(input.wheel_sigma_m, 2));
  variance[1] += std::pow(side_slip(drive_, turned, speed), 2);
  if (!turns_with_ground) variance[0] = kUnknownDistanceSigma_m * kUnknownDistanceSigma_m;
  const Vector3d wheel_at(c.lever_arm.x(), input.wheel_y_m, c.lever_arm.z());
  std::shared_ptr<const Factor> factor;
  if (c.form == WheelForm::kDistance)
    factor = std::make_shared<WheelDistanceFactor>(increment.distance(), std::sqrt(variance[0]),
                                                   wheel_at, c.robust_threshold);
  else
    factor = std::make_shared<WheelFactor>(increment, wheel_at, variance, c.robust_threshold,
                                           slip_of(input.time), places_.back().second);
  add_factor(a, b, factor);
}

// Each moment belongs to the last state before it, and the IMU propagates that state to it.
std::string StateEstimator::add_user_factor(const UserFactor& factor,
                                            Eigen::Matrix2d& place_information) {
  if (gap_s_ > kLongestBridge) return "the IMU is silent";
  std::string wrong = malformed(factor);
  if (!wrong.empty()) return wrong;
  if (factor.times.front() < smoother_.state(smoother_.oldest_id()).time) return kOlderThanWindow;
  if (factor.times.back() > smoother_.newest().time) return "newer than the newest state";
  std::vector<FixedLagSmoother::StateId> from;
  for (TimeNs time : factor.times) {
    auto id = smoother_.newest_id();
    while (smoother_.state(id).time > time) --id;
    from.push_back(id);
  }
  // If both moments belong to the same state, its neighbour serves as the second one.
  auto a = from.front(), b = from.back();
  if (a == b) (a < smoother_.newest_id() ? ++b : --a);
  std::vector<CostFunctionFactor::Moment> moments;
  for (size_t k = 0; k < from.size(); ++k) {
    const NavState& x = smoother_.state(from[k]);
    moments.push_back(
        {from[k] == b, motion_.since(x.time, {x.gyro_bias, x.accel_bias}, factor.times[k])});
  }
  const auto tied = std::make_shared<CostFunctionFactor>(factor, std::move(moments),
                                                         kStandardGravity, smoother_.origin());
  Residual r;
  Jacobian Ja, Jb;
  tied->evaluate(smoother_.state(a), smoother_.state(b), r, &Ja, &Jb);
  if (!r.allFinite() || !Ja.allFinite() || !Jb.allFinite())
    return "the cost function fails at the estimate";
  add_factor(a, b, tied);
  // Information on a common shift of both states. Slip drift is not in the window, so relative to
  // it the residuals' variance is 1 plus the part of the window's own error. That part is below 1
  // once the window has the factor; hence 0.5.
  weight_rows(*tied, r, Ja, Jb);
  const Eigen::MatrixXd shift = (Ja + Jb).middleCols<2>(row::kP);
  place_information += 0.5 * shift.transpose() * shift;
  return "";
}

}  // namespace gprodom
