// Made-up messages of a robot, for tests of what runs the estimator.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "gpr/synthetic_ground.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/input.h"
#include "gprodom/outputs.h"
#include "support/noise.h"

namespace gprodom {

inline constexpr TimeNs kDriveStart = 1'700'000'000'000'000'000;
inline constexpr TimeNs kImuPeriod = 10'000'000;

// The i-th sample of an IMU that is at rest, with a little noise that repeats.
inline ImuSample resting_imu(TimeNs time, int i) {
  ImuSample imu;
  imu.time = time;
  imu.acceleration = {0.002 * (i % 3 - 1), 0.002 * (i % 5 - 2), 9.80665 + 0.002 * (i % 7 - 3)};
  imu.angular_velocity = {4e-4 * (i % 5 - 2), 4e-4 * (i % 3 - 1), 4e-4 * (i % 7 - 3)};
  return imu;
}

// A robot that stands: IMU and wheel at 100 Hz.
inline std::vector<Input> standing(double seconds, TimeNs start = kDriveStart) {
  std::vector<Input> inputs;
  for (int i = 0; i < static_cast<int>(seconds * 100); ++i) {
    inputs.push_back(resting_imu(start + i * kImuPeriod, i));
    inputs.push_back(WheelSample{start + i * kImuPeriod, 0.0});
  }
  return inputs;
}

// What an estimator takes of an input.
template <class Estimator>
void give(Estimator& estimator, const Input& input) {
  std::visit(
      [&estimator](const auto& message) {
        using Message = std::decay_t<decltype(message)>;
        if constexpr (!std::is_same_v<Message, Command> && !std::is_same_v<Message, Rejection>)
          estimator.add(message);
      },
      input);
}

// Of a message; a Rejection has none.
inline TimeNs time_of(const Input& input) {
  return std::visit(
      [](const auto& message) -> TimeNs {
        if constexpr (std::is_same_v<std::decay_t<decltype(message)>, Rejection>)
          return 0;
        else
          return message.time;
      },
      input);
}

inline std::vector<Input> later(std::vector<Input> inputs, double seconds) {
  for (Input& input : inputs)
    std::visit(
        [seconds](auto& message) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(message)>, Rejection>)
            message.time += from_seconds(seconds);
        },
        input);
  return inputs;
}

// What may be told in parts.
inline void append(Outputs& all, const Outputs& more) {
  const auto join = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  join(all.odometry, more.odometry);
  join(all.odometry_in_map, more.odometry_in_map);
  join(all.corrections, more.corrections);
  join(all.displacements, more.displacements);
  join(all.status, more.status);
  join(all.warnings, more.warnings);
}

// To the last bit.
inline bool same_poses(const std::vector<OdometryEstimate>& a,
                       const std::vector<OdometryEstimate>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.time == other.time && one.p_odom_body == other.p_odom_body &&
           one.pose_covariance == other.pose_covariance;
  });
}

// Of every Status.
inline std::vector<std::string> reasons_in(const Outputs& outputs) {
  std::vector<std::string> reasons;
  for (const Status& status : outputs.status)
    reasons.insert(reasons.end(), status.reasons.begin(), status.reasons.end());
  return reasons;
}

inline Config without_radar() {
  Config config = default_config();
  config.gpr.enabled = false;
  config.graph.enabled = false;
  return config;
}

// A robot that stands for 3 s, drives straight ahead for 15 s and, after 2 s, the same way back,
// over ground that its radar sees again: IMU and wheel at 100 Hz, traces at 20 Hz.
inline std::vector<Input> there_and_back(unsigned seed) {
  constexpr double kSpeed = 0.6, kRamp = 1.0, kWay = 15.0;  // m/s, s, s
  const auto speed_since = [](double t) {                   // of one way
    return kSpeed * std::clamp(std::min(t, kWay - t) / kRamp, 0.0, 1.0);
  };
  const auto speed_at = [&](double t) { return speed_since(t - 3.0) - speed_since(t - 20.0); };
  const gpr::SyntheticGround ground(seed);
  gpr::SyntheticRadar radar(seed, 20.0);
  Noise noise(seed);
  std::vector<Input> inputs;
  double position = 0.0;
  for (int i = 0; i < 3700; ++i) {
    const double t = 0.01 * i, speed = speed_at(t), next_speed = speed_at(t + 0.01);
    ImuSample imu;
    imu.time = kDriveStart + i * kImuPeriod;
    imu.acceleration =
        Eigen::Vector3d((next_speed - speed) / 0.01, 0.0, 9.80665) + noise.vector(0.01);
    imu.angular_velocity = noise.vector(0.002);
    inputs.push_back(imu);
    inputs.push_back(WheelSample{imu.time, 1.01 * position});
    if (i % 5 == 0) {
      GprTrace trace = radar.measure(ground, position, t);
      trace.time = imu.time;
      inputs.push_back(std::move(trace));
    }
    position += 0.005 * (speed + next_speed);
  }
  return inputs;
}

// Says at each tick what it was made with.
class Sayer : public gpr::FrontEnd {
 public:
  using Say = std::function<std::vector<gpr::Finding>(TimeNs tick)>;
  explicit Sayer(Say say) : say_(std::move(say)) {}
  void add_trace(const GprTrace& /*trace*/) override {}
  std::vector<gpr::Finding> tick(TimeNs tick) override { return say_(tick); }
  void reset() override {}

 private:
  Say say_;
};

inline gpr::FrontEndFactory saying(Sayer::Say say) {
  return [say = std::move(say)] { return std::make_unique<Sayer>(say); };
}

// Where the drive was when that wheel message came, exactly: in site it goes from (100, 50) towards
// (cos 1, sin 1).
inline PositionFix fix_at(const WheelSample& wheel) {
  const double way = wheel.distance_m / 1.01;
  PositionFix fix;
  fix.time = wheel.time;
  fix.position << 100 + way * std::cos(1.0), 50 + way * std::sin(1.0), 0.0;
  fix.covariance = 4e-4 * Eigen::Matrix3d::Identity();
  fix.quality = FixQuality::kSurveyed;
  return fix;
}

// The drive with a fix after each hundredth wheel message.
inline std::vector<Input> fixed(const std::vector<Input>& inputs) {
  std::vector<Input> with;
  int wheels = 0;
  for (const Input& input : inputs) {
    with.push_back(input);
    const auto* wheel = std::get_if<WheelSample>(&input);
    if (wheel != nullptr && ++wheels % 100 == 0) with.emplace_back(fix_at(*wheel));
  }
  return with;
}

}  // namespace gprodom
