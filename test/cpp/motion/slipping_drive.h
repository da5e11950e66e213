// A drive whose slip is given, with the wheel and the IMU that SlipBelief takes.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "motion/slip/slip_belief.h"
#include "support/noise.h"

namespace gprodom {

inline constexpr double kGravity = 9.80665, kInterval = 0.2;
inline constexpr int kSteps = 20;  // IMU samples an interval
inline constexpr double kMetresPerLength = 0.1;
using OfTime = std::function<double(double)>;

inline double zero(double) { return 0.0; }

// From 0 to 1 within three seconds after `from`, and back before `to`.
inline double ramp(double t, double from, double to) {
  return std::clamp(std::min((t - from) / 3, (to - t) / 3), 0.0, 1.0);
}

// A robot whose speed, turn rate (rad/s) and slip l are given; its wheel and IMU, and what the
// belief makes of them.
class SlippingDrive {
 public:
  // noise: as the belief is told; the IMU's own is `share` of it.
  SlippingDrive(const ImuNoise& noise, OfTime speed, OfTime turn, OfTime slip, double share = 1.0)
      : noise_(noise),
        share_(share),
        speed_(std::move(speed)),
        turn_(std::move(turn)),
        slip_(std::move(slip)) {
    Config config;
    config.wheel.scale_sigma = 0.002;
    belief_.emplace(config);
    start_.state.v_odom.x() = speed_(0);
    start_.covariance.diagonal().setConstant(1e-8);
    start_.covariance(row::kScale, row::kScale) = 4e-6;
  }

  double wheel_y_m = 0.0;             // true lateral position of the wheel; configured is 0
  double jitter_m = 0.0;              // of each interval's wheel distance, one standard deviation
  OfTime disturbed = zero;            // added to the accelerations forwards, m/s^2
  OfTime accel_density;               // of the accelerations' noise, as the belief is told
  std::pair<double, double> silence;  // of the IMU, from a time to another, s
  // Of the gyro's pitch rate, rad/s: by which its bias moves within 20 s, and after which time, s.
  std::pair<double, double> bias_moves;

  void seed(unsigned value) { normal_ = Noise(value); }

  // The accelerometer's bias forwards, m/s^2, as it was seen at standstill. Before the drive.
  void bias(double by) {
    start_.state.accel_bias.x() = by;
    disturbed = [by](double) { return by; };
  }

  // Turns the accelerometer about the up axis against what is configured (rad), and mirrors its x.
  void mount(double yaw, bool mirrored) {
    mount_ << std::cos(yaw), std::sin(yaw), -std::sin(yaw), std::cos(yaw);
    if (mirrored) mount_.row(0) *= -1;
  }

  // From now on, coherence is in another unit: as many times more lengths a metre.
  void change_unit(double times) {
    ++unit_;
    metres_per_length_ /= times;
  }

  // Up to a time, s. coherence: its error, one standard deviation of a span's length; 0: not asked.
  void to(double end, double coherence = 0.0) {
    while (now_ < end - 1e-9) interval(coherence);
  }

  // Of an acceleration of 1 m/s^2 forwards: what the belief says of its error, m/s^2.
  double axes_error() const {
    return belief_->axes_error({{kInterval, {1, 0, kGravity}, {0, 0, 0}, 0.0, false, false, {}}});
  }
  const slip::WheelPosition& position() const { return belief_->position(); }
  double told() const { return belief_->recent().back().l; }
  double sigma() const { return belief_->recent().back().sigma; }
  // Of the oldest interval that is still revised: what the belief leaves, and the error of its l.
  std::optional<double> left() const { return belief_->left(); }
  double oldest_error() const {
    const IntervalSlip oldest = belief_->recent().front();
    return oldest.l - slip_(to_seconds(oldest.to) - 0.5 * kInterval);
  }
  // Of the interval that ended so long ago.
  double told_of(double ago) const {
    const auto recent = belief_->recent();
    return recent.at(recent.size() - 1 - std::lround(ago / kInterval)).l;
  }

 private:
  void interval(double coherence) {
    StateInput input;
    input.time = from_seconds(now_ + kInterval);
    input.has_wheel = true;
    input.noise = noise_;
    if (accel_density) input.noise.accel_density = accel_density(now_);
    const double dt = kInterval / kSteps;
    double way = 0.0, wheel = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = now_ + (i + 0.5) * dt, v = speed_(t), h = 1e-3;
      MotionStep step;
      step.dt = dt;
      step.angular_velocity << 0, 0, turn_(t);
      const auto& [moves_by, moves_after] = bias_moves;
      step.angular_velocity.y() += moves_by * std::clamp((t - moves_after) / 20, 0.0, 1.0);
      step.angular_velocity += normal_.vector(share_ * noise_.gyro_density / std::sqrt(dt));
      step.acceleration << (speed_(t + h) - speed_(t - h)) / (2 * h), v * turn_(t), kGravity;
      step.acceleration.head<2>() = mount_ * step.acceleration.head<2>();
      step.acceleration.x() += disturbed(t);
      step.acceleration += normal_.vector(share_ * noise_.accel_density / std::sqrt(dt));
      step.bridged = t > silence.first && t < silence.second;
      if (step.bridged) step.acceleration << 0, 0, kGravity;
      step.wheel_m = (v - wheel_y_m * turn_(t)) * std::exp(-slip_(t)) * dt;
      way += v * dt;
      if (i == 0) step.wheel_m += jitter_m * normal_();
      wheel += step.wheel_m;
      input.steps.push_back(step);
    }
    belief_->advance(input, start_, {2e-4, 8e-4}, 0.0);
    span_way_ += way;
    span_wheel_ += wheel;
    now_ += kInterval;
    if (coherence > 0 && ++intervals_ % 5 == 0) {
      const double lengths = span_way_ / metres_per_length_ * std::exp(coherence * normal_());
      const TimeNs from = from_seconds(now_ - 5 * kInterval);
      belief_->compare({from, input.time, "radar", true, lengths, 1.0, unit_}, span_wheel_);
      span_way_ = span_wheel_ = 0.0;
    }
  }

  ImuNoise noise_;
  double share_;
  OfTime speed_, turn_, slip_;
  std::optional<SlipBelief> belief_;
  StateResult start_;
  Eigen::Matrix2d mount_ = Eigen::Matrix2d::Identity();
  double now_ = 0.0, span_way_ = 0.0, span_wheel_ = 0.0;
  double metres_per_length_ = kMetresPerLength;
  int intervals_ = 0, unit_ = 0;
  Noise normal_{5};
};

}  // namespace gprodom
