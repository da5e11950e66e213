// What driving shows of accelerations and wheel: each one's noise by itself, whatever the other
// does.
#include "motion/drive_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gprodom {
namespace {

constexpr double kGravity = 9.80665, kInterval_s = 0.2, kRate = 50, kTurn = 0.2;

struct Shown {
  double accel_density, increment_sigma, sideways_density, accel_density_of_one_second;
};

// Two minutes of driving with these noises, `slipping` of the time with a wheel that turns 1.5
// times as fast as it should, for a second at once. bias: of the accelerometer, not known. turn:
// rad/s.
Shown drive(double accel_density, double increment_sigma, double slipping = 0.0, double bias = 0.0,
            double sideways_density = 0.0, double turn = kTurn) {
  DriveNoise noise;
  std::mt19937 random(1), random_sideways(2);
  std::normal_distribution<double> n;
  NavState at;
  double t = 0;
  for (int k = 0; k < 600; ++k) {
    StateInput input;
    input.has_wheel = true;
    input.time = from_seconds((k + 1) * kInterval_s);
    const bool slips = std::fmod(t, 10.0) < 10.0 * slipping;
    double true_m = 0;
    for (int i = 0; i < kInterval_s * kRate; ++i) {
      t += 1 / kRate;
      MotionStep step;
      step.dt = 1 / kRate;
      const double force = 0.3 * std::cos(0.5 * t) + bias;
      step.acceleration = {force + accel_density * std::sqrt(kRate) * n(random), 0, kGravity};
      step.wheel_m = (1.0 + 0.6 * std::sin(0.5 * t)) / kRate;
      step.angular_velocity.z() = turn;
      step.acceleration.y() =
          turn * step.wheel_m * kRate + sideways_density * std::sqrt(kRate) * n(random_sideways);
      true_m += step.wheel_m;
      input.steps.push_back(step);
    }
    input.steps.back().wheel_m += increment_sigma * n(random) + (slips ? 0.5 * true_m : 0.0);
    noise.add(input, at);
    at.time = input.time;
  }
  return {noise.accel_density(), noise.increment_sigma(), noise.sideways_density(),
          noise.accel_density_of_one_second()};
}

TEST(DriveNoise, SeparatesTheNoiseOfImuAndWheel) {
  const Shown shaken = drive(0.1, 0.0005);
  EXPECT_NEAR(shaken.accel_density, 0.1, 0.03);
  EXPECT_LT(shaken.increment_sigma, 0.006);
  const Shown jittery = drive(0.001, 0.01);
  EXPECT_LT(jittery.accel_density, 0.02);
  EXPECT_NEAR(jittery.increment_sigma, 0.01, 0.003);
}

TEST(DriveNoise, SeparatesForwardAndSidewaysNoise) {
  const Shown tilting = drive(0.002, 0.0005, 0.0, 0.0, 0.1);
  EXPECT_NEAR(tilting.sideways_density, 0.1, 0.03);
  EXPECT_LT(tilting.accel_density, 0.01);
  EXPECT_LT(drive(0.1, 0.0005).sideways_density, 0.01);
}

TEST(DriveNoise, SlipAndBiasAreNotCountedAsNoise) {
  const Shown slips = drive(0.002, 0.0005, 0.1, 0.3);
  EXPECT_LT(slips.accel_density, 0.01);
  EXPECT_LT(slips.increment_sigma, 0.002);
}

// On ice a wheel's slip changes all the time, and an IMU that shakes would do so to all sides.
TEST(DriveNoise, WhatIsNotSeenSidewaysIsSlip) {
  const Shown ice = drive(0.01, 0.0005, 0.6, 0.0, 0.01, 0.0);
  EXPECT_LT(ice.accel_density_of_one_second, 0.03);
  EXPECT_GT(ice.accel_density_of_one_second, 0.003);
}

TEST(DriveNoise, ReportsNothingAtAStandstill) {
  DriveNoise noise;
  NavState at;
  for (int k = 0; k < 100; ++k) {
    StateInput input;
    input.has_wheel = true;
    input.time = from_seconds((k + 1) * kInterval_s);
    input.steps = {
        {kInterval_s, {0.3 * (k % 2), 0, kGravity}, {0, 0, 0}, 0.0, false, false, std::nullopt}};
    noise.add(input, at);
    at.time = input.time;
  }
  EXPECT_EQ(noise.accel_density(), 0.0);
  EXPECT_EQ(noise.increment_sigma(), 0.0);
}

}  // namespace
}  // namespace gprodom
