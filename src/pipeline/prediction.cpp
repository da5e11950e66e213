#include "pipeline/prediction.h"

#include <algorithm>

namespace gprodom {

void Prediction::rebase(const StateResult& base, const ImuNoise& noise,
                        const Eigen::Vector3d& contact_body, const ImuHistory& imu) {
  const bool was_lost = lost();
  base_ = base;
  noise_ = noise;
  contact_body_ = contact_body;
  ways_.clear();
  since_ = ImuPreintegration(noise, base.state.gyro_bias, base.state.accel_bias);
  bridged_s_ = 0.0;
  if (time_ == 0) {
    time_ = base.state.time;
    p_counted_odom_ = base.state.p_odom;
  }
  integrate(imu, base.state.time, time_);
  // The end of the gap is known now. The straight line across it is the least distance driven.
  if (was_lost && !lost()) distance_m_ += (position() - p_counted_odom_).norm();
}

void Prediction::integrate(const ImuHistory& imu, TimeNs from, TimeNs to) {
  for (const MotionStep& step : imu.steps(from, to)) {
    since_.integrate(step.acceleration, step.angular_velocity, step.dt,
                     step.bridged ? kBridgedImuNoise : noise_);
    if (step.bridged) bridged_s_ += step.dt;
    omega_body_ = step.angular_velocity - base_.state.gyro_bias;
    const PredictedWay before = ways_.empty() ? way_begins(base_.state) : ways_.back();
    ways_.push_back(way_further(before, base_.state, since_, contact_body_, kStandardGravity));
  }
}

const PredictedWay* Prediction::way(TimeNs to) const {
  const auto later = std::partition_point(ways_.begin(), ways_.end(),
                                          [to](const PredictedWay& w) { return w.time <= to; });
  return later == ways_.begin() ? nullptr : &*(later - 1);
}

OdometryEstimate Prediction::advance(const ImuHistory& imu, TimeNs now) {
  integrate(imu, time_, now);
  OdometryEstimate estimate = predict(base_.state, base_.covariance, since_, kStandardGravity);
  estimate.pose_covariance.topLeftCorner<2, 2>() += base_.unmodelled_covariance;
  if (!base_.standing && !lost()) distance_m_ += estimate.v_body.norm() * to_seconds(now - time_);
  if (!lost()) p_counted_odom_ = estimate.p_odom_body;
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
  result.standing = !initial.on_the_move;
  return result;
}

}  // namespace gprodom
