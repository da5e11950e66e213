// A robot whose sensor data are set by a test, and the judge that gets them.
#pragma once

#include <cmath>

#include "motion/motion_judge.h"
#include "support/noise.h"

namespace gprodom {

constexpr ImuNoise kReference{2e-4, 8e-4};
constexpr double kImuRate = 200, kWheelRate = 50;  // Hz
constexpr TimeNs kInterval = 200'000'000;          // ns, between states
constexpr double kStart = 1000.0;                  // s
constexpr double kSpeed = 0.5;                     // m/s
inline const Eigen::Vector3d kBias(1e-3, -2e-3, 3e-3);

inline gpr::TrackDisplacement moved(double from, double to) {
  return {from_seconds(from), from_seconds(to), "radar", true, 0.1, 0.02, 1.0};
}

inline gpr::PathLength went(double from, double to, double lengths) {
  return {from_seconds(from), from_seconds(to), "radar", true, lengths, 1.0};
}

inline gpr::Standstill stood(double from, double to) {
  return {from_seconds(from), from_seconds(to), "radar", 1e-3, 1.0};
}

// What the wheel has rolled in the interval.
inline double rolled_m(const StateInput& input) {
  double sum = 0.0;
  for (const MotionStep& step : input.steps) sum += step.wheel_m;
  return sum;
}

// A robot whose sensors say what the test sets, and whose states and estimates are exact.
class Robot {
 public:
  // mps: of the robot and of its wheel.
  explicit Robot(const Config& config = {}, double mps = 0.0)
      : judge(config), speed(mps), wheel_speed(mps) {
    newest.state.time = from_seconds(kStart);
    newest.state.gyro_bias = kBias;
    newest.solve.usable = true;
    newest.standing = true;
    judge.begin(newest, {newest.state, {}, kReference});
  }

  MotionJudge judge;

  void receive(const gpr::Finding& finding) {
    judge.add_radar(finding, PlacedDisplacement(judge.in_metres(finding)));
  }
  double speed, wheel_speed;  // m/s
  double vibration = 1.0;     // of the noise at standstill
  double extra_rate = 0.0;    // rad/s about z, beyond the bias
  double acceleration = 0.0;  // m/s^2, forwards
  bool imu_speaks = true, wheel_speaks = true;
  int imu_every = 1;   // of kImuRate
  StateResult newest;  // in effect; its time and standing are set here
  int slips_told = 0;
  std::int32_t flags = 0;  // of the last estimate

  double now() const { return kStart + i_ / kImuRate; }

  // Drives for one state interval. The answer for it, after the reorder window.
  StateInput next() {
    const double step = 1 / kImuRate;
    for (int n = 0; n < to_seconds(kInterval) * kImuRate; ++n, ++i_) {
      const TimeNs time = from_seconds(now());
      if (imu_speaks && i_ % imu_every == 0) judge.add(sample(time));
      if (wheel_speaks && i_ % static_cast<int>(kImuRate / kWheelRate) == 0)
        judge.add(WheelSample{time, wheel_m_});
      wheel_m_ += wheel_speed * step;
      OdometryEstimate estimate;
      estimate.time = time;
      estimate.v_body.x() = speed;
      estimate.velocity_covariance = 1e-4 * Eigen::Matrix3d::Identity();
      slips_told += judge.follow(estimate);
      flags = estimate.flags;
    }
    judge.add(sample(from_seconds(now())));  // both ends of the interval are covered
    if (wheel_speaks) judge.add(WheelSample{from_seconds(now()), wheel_m_});
    const StateInput input = judge.judge(from_seconds(now()));
    newest.state.time = input.time;
    newest.state.v_odom.x() = speed;
    newest.standing = input.standing;
    judge.adopt(newest);
    return input;
  }

  StateInput drive(int intervals) {
    StateInput last;
    for (int i = 0; i < intervals; ++i) last = next();
    return last;
  }

 private:
  ImuSample sample(TimeNs time) {
    ImuSample s{time, {acceleration, 0, 9.80665}, kBias};
    s.angular_velocity.z() += extra_rate;
    const double scale = vibration * std::sqrt(kImuRate / imu_every);
    noise_.shake(s, scale * kReference.accel_density, scale * kReference.gyro_density);
    return s;
  }

  double wheel_m_ = 3.0;
  int i_ = 0;
  Noise noise_{1};
};

}  // namespace gprodom
