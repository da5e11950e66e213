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

using OfTime = std::function<double(double seconds)>;

// A robot in the plane, of given speed (m/s) and turn rate (rad/s): where it is, and what an IMU
// without noise says, 100 times a second.
class PlanarRobot {
 public:
  explicit PlanarRobot(
      OfTime speed, OfTime rate = [](double) { return 0.0; })
      : speed_(std::move(speed)), rate_(std::move(rate)) {}

  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double way_m = 0.0, yaw = 0.0;

  double seconds() const { return 0.01 * i_; }
  ImuSample imu() const {
    const double t = seconds(), speed = speed_(t);
    return {kDriveStart + i_ * kImuPeriod,
            {(speed_(t + 0.01) - speed) / 0.01, speed * rate_(t), 9.80665},
            {0.0, 0.0, rate_(t)}};
  }
  void move() {
    const double t = seconds(), went = 0.005 * (speed_(t) + speed_(t + 0.01));
    position += went * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.0);
    way_m += went;
    yaw += 0.005 * (rate_(t) + rate_(t + 0.01));
    ++i_;
  }

 private:
  OfTime speed_, rate_;
  int i_ = 0;
};

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

// All that an estimator tells of these, to their end.
template <class Estimator>
Outputs run(Estimator& estimator, const std::vector<Input>& inputs) {
  Outputs all;
  for (const Input& input : inputs) {
    give(estimator, input);
    append(all, estimator.step());
  }
  append(all, estimator.finish());
  return all;
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
  return default_config({"gpr.enabled=false", "graph.enabled=false"});
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
  PlanarRobot robot(speed_at);
  for (int i = 0; i < 3700; ++i, robot.move()) {
    ImuSample imu = robot.imu();
    imu.acceleration += noise.vector(0.01);
    imu.angular_velocity = noise.vector(0.002);
    inputs.push_back(imu);
    inputs.push_back(WheelSample{imu.time, 1.01 * robot.way_m});
    if (i % 5 == 0) {
      GprTrace trace = radar.measure(ground, robot.way_m, robot.seconds());
      trace.time = imu.time;
      inputs.push_back(std::move(trace));
    }
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
