// An accelerometer with a wrong scale or a large bias, through the whole estimator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "estimation/nav_state.h"
#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"
#include "support/noise.h"
#include "support/told.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;
using Sensor = std::function<Vector3d(const Vector3d&)>;  // what it makes of a specific force

constexpr double kRound_s = 6.0;

struct Driven {
  std::optional<double> start_s;
  double worst_m = 0.0;  // error of the position
  std::vector<std::string> reasons;
  bool told(const std::string& text) const { return count_with(reasons, text) > 0; }
};

// A robot that stands for `stands` seconds, and then turns on the spot by 0.7 rad and goes ahead by
// 0.75 m, for 3 s each.
Driven drive(const Sensor& sensor, double stands_s = 3.0, unsigned seed = 1) {
  Driven run;
  Odometry odometry(without_radar());
  Noise noise(seed);
  const auto bump = [](double t) { return 0.5 - 0.5 * std::cos(2 * M_PI * t / (0.5 * kRound_s)); };
  const auto speed_at = [&](double t) {
    const double in_round = t < stands_s ? 0.0 : std::fmod(t - stands_s, kRound_s);
    return in_round > 0.5 * kRound_s ? 0.5 * bump(in_round) : 0.0;
  };
  const auto rate_at = [&](double t) {
    const double in_round = t < stands_s ? kRound_s : std::fmod(t - stands_s, kRound_s);
    return in_round < 0.5 * kRound_s ? 0.47 * bump(in_round) : 0.0;
  };
  double wheel_m = 0.0, yaw = 0.0, first_yaw = 0.0;
  Vector3d position = Vector3d::Zero(), first = Vector3d::Zero();
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i, speed = speed_at(t), next_speed = speed_at(t + 0.01);
    ImuSample imu;
    imu.time = kDriveStart + i * kImuPeriod;
    imu.acceleration =
        sensor(Vector3d((next_speed - speed) / 0.01, speed * rate_at(t), kStandardGravity) +
               noise.vector(0.02));
    imu.angular_velocity = Vector3d(0, 0, rate_at(t)) + noise.vector(0.001);
    odometry.add(imu);
    odometry.add(WheelSample{imu.time, wheel_m});
    const Outputs out = odometry.step();
    for (const OdometryEstimate& estimate : out.odometry) {
      if (!run.start_s) {
        run.start_s = t;
        first = position;
        first_yaw = yaw;
      }
      const Vector3d moved = Eigen::AngleAxisd(-first_yaw, Vector3d::UnitZ()) * (position - first);
      run.worst_m = std::max(run.worst_m, (estimate.p_odom_body - moved).head<2>().norm());
    }
    for (const std::string& reason : reasons_in(out)) run.reasons.push_back(reason);
    const double went = 0.005 * (speed + next_speed);
    position += went * Vector3d(std::cos(yaw), std::sin(yaw), 0);
    wheel_m += went;
    yaw += 0.005 * (rate_at(t) + rate_at(t + 0.01));
  }
  return run;
}

Sensor scaled(double scale) {
  return [scale](const Vector3d& force) { return Vector3d(scale * force); };
}

const char* const kTold = "accelerometer: its specific force is ";

TEST(Accelerometer, AWrongScaleIsTakenOutAndTold) {
  const Driven right = drive(scaled(1.0));
  ASSERT_TRUE(right.start_s);
  EXPECT_LT(right.worst_m, 0.03);
  EXPECT_FALSE(right.told("accelerometer"));
  for (const double scale : {0.55, 0.8, 1.2, 1.45}) {
    const Driven run = drive(scaled(scale));
    ASSERT_TRUE(run.start_s) << scale;
    EXPECT_EQ(*run.start_s, *right.start_s);
    EXPECT_NEAR(run.worst_m, right.worst_m, 2e-3) << scale;
    const std::string percent = std::to_string(std::lround(100 * scale));
    EXPECT_TRUE(run.told(kTold + percent + " % of gravity")) << scale;
  }
}

// Another unit, or no accelerometer.
TEST(Accelerometer, WhatIsFarFromGravityIsNoScale) {
  for (const double scale : {1 / kStandardGravity, 0.0, 0.4, 1.6}) {
    const Driven run = drive(scaled(scale), 60.0);
    EXPECT_FALSE(run.start_s) << scale;
    EXPECT_TRUE(run.told("is not gravity")) << scale;
    EXPECT_FALSE(run.told(kTold)) << scale;
  }
}

// Accelerations of a drive are not known so well: it waits for as long as for other signs.
TEST(Accelerometer, AWrongScaleIsTakenOutOnTheMove) {
  for (const double scale : {0.8, 1.2}) {
    const Driven run = drive(scaled(scale), -2.9);
    ASSERT_TRUE(run.start_s) << scale;
    EXPECT_LT(*run.start_s, 15.0);
    EXPECT_LT(run.worst_m, 0.1) << scale;
    EXPECT_TRUE(run.told(kTold)) << scale;
  }
}

// Across gravity no standstill tells a bias from a tilt; along it, that the sensor has some.
TEST(Accelerometer, ABiasIsLearntFromTurnsIfGravityShowsThatThereIsSome) {
  const Vector3d bias(0.3, -0.2, 0.2);
  const Sensor biased = [&](const Vector3d& force) { return Vector3d(force + bias); };
  double mean_m = 0.0, right_m = 0.0;
  constexpr unsigned kDrives = 12;
  for (unsigned seed = 1; seed <= kDrives; ++seed) {
    mean_m += drive(biased, 3.0, seed).worst_m / kDrives;
    right_m += drive(scaled(1.0), 3.0, seed).worst_m / kDrives;
  }
  EXPECT_LT(mean_m, right_m + 0.01);
}

// An encoder of some centimetres a tick, as a few magnets on a wheel give it.
// Goes 1.4 m in 4 s and stands for 2 s, again and again. The greatest error of the position, m.
double worst_error(unsigned seed, double tick_m, double resolution_m) {
  constexpr double kStands = 3.0, kGoes = 4.0, kRound = 6.0, kSpeed = 0.7;  // s, m/s
  Config config = default_config();
  config.gpr.enabled = false;
  Odometry odometry(config);
  Noise noise(seed);
  const auto speed_at = [&](double t) {
    const double in_round = t < kStands ? kRound : std::fmod(t - kStands, kRound);
    const double middle = 0.5 * kGoes;
    return kSpeed * std::max(0.0, 1.0 - std::abs(in_round - middle) / middle);
  };
  double position = 0.0, worst = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const double t = 0.01 * i, speed = speed_at(t), next_speed = speed_at(t + 0.01);
    ImuSample imu;
    imu.time = kDriveStart + i * kImuPeriod;
    imu.acceleration =
        Eigen::Vector3d((next_speed - speed) / 0.01, 0.0, 9.80665) + noise.vector(0.05);
    imu.angular_velocity = noise.vector(0.002);
    odometry.add(imu);
    if (i % 5 == 0)
      odometry.add(WheelSample{imu.time, tick_m * std::floor(position / tick_m), resolution_m});
    for (const OdometryEstimate& estimate : odometry.step().odometry)
      if (estimate.time == imu.time)
        worst = std::max(worst, std::abs(estimate.p_odom_body.x() - position));
    position += 0.005 * (speed + next_speed);
  }
  return worst;
}

TEST(CoarseEncoder, ItsTicksAreNeitherSlipNorStandstill) {
  for (const double tick_m : {0.02, 0.05}) {
    double with = 0.0, without = 0.0;
    for (const unsigned seed : {1, 2}) {
      with = std::max(with, worst_error(seed, tick_m, tick_m));
      without = std::max(without, worst_error(seed, tick_m, 0.0));
    }
    EXPECT_LT(with, 0.05 + 4 * tick_m);
    EXPECT_GT(without, 4 * with) << "the resolution need not be known";
  }
}

}  // namespace
}  // namespace gprodom
