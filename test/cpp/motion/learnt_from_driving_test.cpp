// What a drive shows: how long a length of coherence is, the noise of accelerations and wheel, and
// the size of a gyro's bias.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "motion/coherence_scale.h"
#include "motion/drive_noise.h"
#include "motion/gyro_bias_size.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kSpeed = 0.4;  // m/s

struct Answer {
  double time, distance_m, sigma_m;
  bool valid;
};

// A robot at kSpeed; each span of 1 s errs by a factor exp(spread * normal). What holds at each
// time:
struct Drive {
  unsigned seed;
  int seconds;
  double spread;
  std::function<double(double)> metres_per_length = [](double) { return 0.06; };  // of the ground
  std::function<std::int32_t(double)> flags = [](double) { return 0; };
  std::function<double(double)> seen = [](double) { return 1.0; };  // published speed over true
  std::function<bool(double)> speed_known = [](double) { return true; };
  std::function<int(double)> unit = [](double) { return 0; };
};

std::vector<Answer> driven(const Drive& drive) {
  Noise normal(drive.seed);
  CoherenceScale scale;
  std::vector<Answer> answers;
  for (int i = 0; i <= drive.seconds * 200; ++i) {
    const double t = i * 0.005;
    OdometryEstimate estimate;
    estimate.time = from_seconds(10 + t);
    estimate.v_body.x() = kSpeed * drive.seen(t);
    estimate.flags = drive.flags(t);
    scale.add(estimate, drive.speed_known(t));
    if (i == 0 || i % 200 != 0) continue;
    const double lengths = kSpeed / drive.metres_per_length(t) * std::exp(drive.spread * normal());
    const Displacement metres = scale.to_metres(
        {from_seconds(9 + t), estimate.time, "radar", true, lengths, 1.0, drive.unit(t)});
    answers.push_back({t, metres.distance_m, metres.sigma_m, metres.valid});
  }
  return answers;
}

TEST(CoherenceScale, VarianceIsThatOfTheErrors) {
  for (const double spread : {0.08, 0.15, 0.3}) {
    double squares = 0, n = 0;
    for (unsigned seed = 0; seed < 100; ++seed)
      for (const Answer& a : driven({seed, 120, spread}))
        if (a.time > 60) {
          ASSERT_TRUE(a.valid);
          squares += std::pow((a.distance_m - kSpeed) / a.sigma_m, 2);
          ++n;
        }
    // The errors of spans are independent here, and the reported variance is doubled.
    EXPECT_GT(squares / n, 0.3) << spread;
    EXPECT_LT(squares / n, 0.7) << spread;
  }
}

TEST(CoherenceScale, HasALargeVarianceAtFirstAndNoValueBeforeLearning) {
  const auto answers = driven({1, 60, 0.1});
  EXPECT_FALSE(answers[2].valid);
  EXPECT_TRUE(answers[12].valid);
  EXPECT_GT(answers[12].sigma_m, 1.3 * answers[58].sigma_m);
}

TEST(CoherenceScale, FollowsTheGround) {
  const auto answers = driven({2, 120, 0.05, [](double t) { return t < 60 ? 0.06 : 0.03; }});
  EXPECT_NEAR(answers[58].distance_m, kSpeed, 0.06);
  EXPECT_NEAR(answers[118].distance_m, kSpeed, 0.06);
  EXPECT_GT(answers[64].sigma_m, 2 * answers[58].sigma_m);  // the jump was not foreseen
}

TEST(CoherenceScale, BeginsAnewWithAnotherUnit) {
  Drive drive{1, 84, 0.0};
  drive.unit = [](double t) { return t <= 41 ? 1 : 2; };
  drive.metres_per_length = [&](double t) { return drive.unit(t) == 1 ? 0.1 : kSpeed / 12; };
  const auto answers = driven(drive);
  EXPECT_NEAR(answers[40].distance_m, kSpeed, 1e-3);
  EXPECT_FALSE(answers[41].valid) << "not learnt yet";
  EXPECT_TRUE(answers.back().valid);
  EXPECT_NEAR(answers.back().distance_m, kSpeed, 1e-3);
}

// The published speed is wrong from 60 s on; a slip is flagged up to half a second late.
TEST(CoherenceScale, LearnsNothingFromASlipNorFromASpeedThatIsNotKnown) {
  Drive slips{3, 90, 0.05};
  slips.seen = [](double t) { return t > 60 ? 1.8 : 1.0; };
  Drive unknown = slips;
  slips.flags = [](double t) { return t > 60.4 && t < 90 ? kSlipping : 0; };
  unknown.speed_known = [](double t) { return t <= 60; };
  for (const Drive& drive : {slips, unknown}) {
    const auto answers = driven(drive);
    for (const Answer& a : answers) {
      if (a.time <= 20) continue;
      EXPECT_NEAR(a.distance_m, kSpeed, 0.08) << a.time;
    }
    // The variance grows with distance.
    EXPECT_GT(answers[88].sigma_m, 1.15 * answers[62].sigma_m);
  }
}

// What driving shows of accelerations and wheel: each one's noise by itself, whatever the other
// does.

constexpr double kGravity = 9.80665, kInterval_s = 0.2, kRate = 50, kTurn = 0.2;

struct Shown {
  double accel_density, increment_sigma, sideways_density, accel_density_of_one_second;
};

// Two minutes of driving with these noises, `slipping` of the time with a wheel that turns 1.5
// times as fast as it should, for a second at once. bias: of the accelerometer, not known. turn:
// rad/s.
Shown noise_shown(double accel_density, double increment_sigma, double slipping = 0.0,
                  double bias = 0.0, double sideways_density = 0.0, double turn = kTurn) {
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
  const Shown shaken = noise_shown(0.1, 0.0005);
  EXPECT_NEAR(shaken.accel_density, 0.1, 0.03);
  EXPECT_LT(shaken.increment_sigma, 0.006);
  const Shown jittery = noise_shown(0.001, 0.01);
  EXPECT_LT(jittery.accel_density, 0.02);
  EXPECT_NEAR(jittery.increment_sigma, 0.01, 0.003);
}

TEST(DriveNoise, SeparatesForwardAndSidewaysNoise) {
  const Shown tilting = noise_shown(0.002, 0.0005, 0.0, 0.0, 0.1);
  EXPECT_NEAR(tilting.sideways_density, 0.1, 0.03);
  EXPECT_LT(tilting.accel_density, 0.01);
  EXPECT_LT(noise_shown(0.1, 0.0005).sideways_density, 0.01);
}

TEST(DriveNoise, SlipAndBiasAreNotCountedAsNoise) {
  const Shown slips = noise_shown(0.002, 0.0005, 0.1, 0.3);
  EXPECT_LT(slips.accel_density, 0.01);
  EXPECT_LT(slips.increment_sigma, 0.002);
}

// On ice a wheel's slip changes all the time, and an IMU that shakes would do so to all sides.
TEST(DriveNoise, WhatIsNotSeenSidewaysIsSlip) {
  const Shown ice = noise_shown(0.01, 0.0005, 0.6, 0.0, 0.01, 0.0);
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

// The size of a gyro's bias, from a drive of four seconds over uneven ground with bends.

using Eigen::Vector3d;

struct BumpyDrive {
  Vector3d bias = Vector3d::Zero();  // rad/s
  double vibration = 0.0;            // m/s^2, of single samples at 100 Hz
  double slope = 0.0;                // rad, amplitude of roll and pitch
  double slip = 0.0;                 // of the wheel, from 1.5 s to 2.5 s
};

GyroBiasSize size_of(const BumpyDrive& drive, unsigned seed) {
  Noise n(seed);
  const auto speed = [](double t) { return 1.0 + 0.3 * std::sin(1.5 * t); };
  std::vector<ImuSample> samples;
  for (int i = 0; i <= 400; ++i) {
    const double t = i * 0.01, turning = 0.4 * std::cos(t);
    const double roll = drive.slope * std::sin(1.1 * t), pitch = drive.slope * std::cos(0.8 * t);
    const double roll_rate = 1.1 * drive.slope * std::cos(1.1 * t);
    const double pitch_rate = -0.8 * drive.slope * std::sin(0.8 * t);
    const double g = kStandardGravity;
    // To first order in roll and pitch.
    const Vector3d force(-g * pitch + 0.45 * std::cos(1.5 * t), g * roll + turning * speed(t), g);
    const Vector3d rate(roll_rate - turning * pitch, pitch_rate + turning * roll, turning);
    samples.push_back(
        {from_seconds(t), force + drive.vibration * Vector3d(n(), n(), n()), rate + drive.bias});
  }
  WheelSpeeds wheel;
  for (int k = 0; k < 20; ++k) {
    const double t = (k + 0.5) * WheelSpeeds::kPart;
    const bool slips = t > 1.5 && t < 2.5;
    wheel.mps.push_back(speed(t) * (slips ? 1 + drive.slip : 1.0) + 0.005 * n());
  }
  return gyro_bias_size(samples, wheel);
}

// The biases of a car's gyro on record (rad/s), and of one that is far better.
const Vector3d kCheap(-0.016, 0.0157, 0.006), kGood(-3e-4, 2e-4, 1e-4);

TEST(GyroBiasSize, IsThatOfTheTwoAxesThatGravityShows) {
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const double slope : {0.0, 0.05})
      for (const double vibration : {0.0, 0.5}) {
        const double cheap = size_of({kCheap, vibration, slope, 0.0}, seed).sigma;
        EXPECT_GT(cheap, 0.006) << slope << " " << vibration;
        EXPECT_LT(cheap, 0.016) << slope << " " << vibration;
        const double good = size_of({kGood, vibration, slope, 0.0}, seed).sigma;
        EXPECT_NEAR(good, kUsualGyroBias, 5e-4) << slope << " " << vibration;
      }
}

TEST(GyroBiasSize, IsNotMadeByASlip) {
  for (unsigned seed = 0; seed < 20; ++seed)
    EXPECT_LT(size_of({kGood, 0.1, 0.02, 0.5}, seed).sigma, 0.005);
}

TEST(GyroBiasSize, IsNotKnownUnderStrongVibration) {
  EXPECT_TRUE(size_of({kCheap, 0.1, 0.02, 0.0}, 1).known);
  EXPECT_FALSE(size_of({kCheap, 10.0, 0.02, 0.0}, 1).known);
}

// An accelerometer with a reversed axis shows such a bias in bends and starts.
TEST(GyroBiasSize, IsTheUsualOneWhereNoGyroIsOffBySoMuch) {
  const GyroBiasSize size = size_of({Vector3d(0.0, 0.3, 0.0), 0.1, 0.02, 0.0}, 1);
  EXPECT_EQ(size.sigma, kUsualGyroBias);
  EXPECT_FALSE(size.known);
}

TEST(GyroBiasSize, IsTheUsualOneWhereDataAreMissing) {
  for (const std::size_t parts : {0, 20}) {
    const GyroBiasSize size = gyro_bias_size({}, {0, std::vector<double>(parts, 1.0)});
    EXPECT_EQ(size.sigma, kUsualGyroBias);
    EXPECT_FALSE(size.known);
  }
}

}  // namespace
}  // namespace gprodom
