#include "pipeline/prediction.h"

#include "motion/standstill.h"

namespace gprodom {

void Prediction::rebase(const StateResult& base, const ImuNoise& noise, const ImuHistory& imu) {
  base_ = base;
  noise_ = noise;
  since_ = ImuPreintegration(noise, base.state.gyro_bias, base.state.accel_bias);
  bridged_s_ = 0.0;
  if (time_ == 0) time_ = base.state.time;
  integrate(imu, base.state.time, time_);
}

void Prediction::integrate(const ImuHistory& imu, TimeNs from, TimeNs to) {
  for (const MotionStep& step : imu.steps(from, to, max_gap_)) {
    since_.integrate(step.acceleration, step.angular_velocity, step.dt,
                     step.bridged ? kBridgedImuNoise : noise_);
    if (step.bridged) bridged_s_ += step.dt;
    omega_body_ = step.angular_velocity - base_.state.gyro_bias;
  }
}

OdometryEstimate Prediction::advance(const ImuHistory& imu, TimeNs now) {
  integrate(imu, time_, now);
  OdometryEstimate estimate = predict(base_.state, base_.covariance, since_, gravity_);
  if (!base_.standing && !lost()) distance_m_ += estimate.v_body.norm() * to_seconds(now - time_);
  time_ = now;
  estimate.time = now;
  estimate.omega_body = omega_body_;
  estimate.distance_m = distance_m_;
  return estimate;
}

StateResult initial_result(const InitialState& initial) {
  StateResult result;
  result.state = initial.state;
  result.covariance = (initial.prior.A.transpose() * initial.prior.A).inverse();
  result.solve.usable = true;
  result.standing = true;
  return result;
}

ImuNoise prevailing_noise(const std::vector<ImuSample>& samples, const ImuNoise& reference) {
  constexpr size_t kEnough = 20;
  constexpr double kSignificant = 1.2;  // three deviations of what 80 samples show
  if (samples.size() < kEnough) return reference;
  const ImuNoise measured = measured_noise(samples);
  auto prevailing = [](double at_rest, double now) {
    return now > kSignificant * at_rest ? now : at_rest;
  };
  return {prevailing(reference.gyro_density, measured.gyro_density),
          prevailing(reference.accel_density, measured.accel_density)};
}

bool add_wheel(std::vector<MotionStep>& steps, const WheelHistory& wheel, TimeNs from,
               bool across_gaps) {
  double elapsed = 0;
  std::optional<double> before = wheel.distance(from, across_gaps);
  for (MotionStep& step : steps) {
    elapsed += step.dt;
    const std::optional<double> after = wheel.distance(from + from_seconds(elapsed), across_gaps);
    if (!before || !after) {
      for (MotionStep& s : steps) s.wheel_m = 0;
      return false;
    }
    step.wheel_m = *after - *before;
    before = after;
  }
  return !steps.empty();
}

}  // namespace gprodom
