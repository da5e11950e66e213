// Conditions for a standstill, and for a step of the gyro bias: a steady rate while all other
// sensors show a standstill, and no other case.
#include "motion/rest/standstill.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noise.h"

namespace gprodom {
namespace {

constexpr ImuNoise kReference{2e-4, 8e-4};
constexpr double kImuRate = 200, kWheelRate = 30;  // Hz
constexpr double kInterval_s = 0.2;

// Of ten seconds.
struct Robot {
  double rate = 0.0;       // rad/s about z, what the gyro says beyond its known bias
  double ramp = 0.0;       // rad/s^2, by which that grows
  double vibration = 1.0;  // of the noise at standstill
  double speed = 0.0;      // m/s, of the wheel
  bool radar_stands = true;
  double resting_wheel = 0.0;  // m/s, that is known of its wheel
  double bias_sigma = 0.0;     // rad/s, of the gyro's known bias
  double unseen = 0.0;         // m/s, of slower motion that the radar does not see
  double imu_rate = kImuRate;  // Hz
};

struct Judged {
  bool standing;
  bool steady;
  std::optional<Eigen::Vector3d> bias;  // of the first that was told
  bool turns = false;                   // told: too fast for a step of the bias
  double share = 0.0;                   // of the intervals, in which it stands
};

// All the intervals from 1 to 9 s: `standing` and `steady` where every one was.
Judged judge(const Robot& robot, const Config& config = {}) {
  const Eigen::Vector3d known_bias(1e-3, -2e-3, 3e-3);
  Noise noise(1);
  ImuHistory imu;
  const double scale = robot.vibration * std::sqrt(robot.imu_rate);
  for (int i = 0; i < 10 * robot.imu_rate; ++i) {
    ImuSample sample;
    sample.time = from_seconds(i / robot.imu_rate);
    sample.acceleration = Eigen::Vector3d(0, 0, 9.80665);
    sample.angular_velocity = known_bias;
    sample.angular_velocity.z() += robot.rate + robot.ramp * i / robot.imu_rate;
    noise.shake(sample, scale * kReference.accel_density, scale * kReference.gyro_density);
    imu.insert(sample);
  }
  WheelHistory wheel(config.wheel.max_speed);
  for (int i = 0; i < 10 * kWheelRate; ++i)
    wheel.insert({from_seconds(i / kWheelRate), robot.speed * i / kWheelRate});
  std::vector<gpr::Standstill> radar(robot.radar_stands ? 1 : 0);
  for (gpr::Standstill& standstill : radar) standstill.to = from_seconds(10.0);

  Judged judged{true, true, std::nullopt};
  BiasWatch watch;
  for (int i = 5; i < 45; ++i) {
    const auto verdict = judge_standstill(
        config,
        {kReference, robot.resting_wheel, known_bias, robot.bias_sigma, robot.unseen, true,
         config.gpr.enabled},
        imu, wheel, radar, from_seconds(i * kInterval_s), from_seconds((i + 1) * kInterval_s));
    judged.standing &= verdict.standing;
    judged.share += verdict.standing / 40.0;
    judged.steady &= verdict.steady_rate.has_value();
    const auto bias = watch.new_bias(verdict, known_bias, kInterval_s);
    judged.turns |= watch.turns_at_rest();
    if (bias && !judged.bias) judged.bias = *bias - known_bias;
  }
  return judged;
}

TEST(Standstill, StillImuAndEitherWheelOrRadarAreEnough) {
  EXPECT_TRUE(judge({}).standing);
  Robot sees_nothing;
  sees_nothing.radar_stands = false;
  EXPECT_TRUE(judge(sees_nothing).standing);
  Robot spinning_wheel;
  spinning_wheel.speed = 0.3;
  EXPECT_TRUE(judge(spinning_wheel).standing);
  Robot neither = spinning_wheel;
  neither.radar_stands = false;
  EXPECT_FALSE(judge(neither).standing);
  Robot shaken;
  shaken.vibration = 5.0;
  EXPECT_FALSE(judge(shaken).standing);
}

// Two or three samples between two states show no vibration: those before count as well.
TEST(Standstill, ASlowImuShowsIt) {
  for (const double rate : {10.0, 18.0}) {
    Robot robot;
    robot.imu_rate = rate;
    robot.radar_stands = false;
    EXPECT_GT(judge(robot).share, 0.7) << rate;
    Robot shaken = robot, turning = robot;
    shaken.vibration = 3.0;
    EXPECT_EQ(judge(shaken).share, 0.0) << rate;
    turning.rate = 0.02;
    EXPECT_EQ(judge(turning).share, 0.0) << rate;
  }
}

// A robot that starts to creep, over ground on which the radar cannot see such slow motion.
TEST(Standstill, RadarDoesNotContradictAWheelBelowItsSight) {
  Robot creeping;
  creeping.speed = 0.04;
  EXPECT_TRUE(judge(creeping).standing);
  creeping.unseen = 0.05;
  EXPECT_FALSE(judge(creeping).standing);
  creeping.speed = 0.06;
  EXPECT_TRUE(judge(creeping).standing);
  creeping.speed = 0.0;
  EXPECT_TRUE(judge(creeping).standing);
}

TEST(BiasWatch, SteadyRateAtAStandstillIsTheBias) {
  for (const double rate : {5e-3, 0.02, 0.04}) {
    Robot stepped;
    stepped.rate = rate;
    const Judged judged = judge(stepped);
    EXPECT_FALSE(judged.standing);
    EXPECT_TRUE(judged.steady);
    EXPECT_FALSE(judged.turns);
    ASSERT_TRUE(judged.bias) << rate;
    EXPECT_LT((*judged.bias - Eigen::Vector3d(0, 0, rate)).norm(), 5e-4);  // over a second
  }
}

TEST(BiasWatch, ASteadyTurnAtAStandstillIsTold) {
  Robot stepped;
  stepped.rate = 0.1;
  EXPECT_TRUE(judge(stepped).turns);
  stepped.vibration = 5.0;
  EXPECT_FALSE(judge(stepped).turns);
}

TEST(BiasWatch, OtherRatesAreNotTheBias) {
  Robot still;
  EXPECT_FALSE(judge(still).bias);
  Robot stepped;
  stepped.rate = 5e-3;
  Robot shaken = stepped, rolling = stepped, unseen = stepped, turning = stepped,
        changing = stepped;
  shaken.vibration = 5.0;
  rolling.speed = 0.3;
  unseen.radar_stands = false;
  turning.rate = 0.1;
  changing.ramp = 0.02;
  for (const Robot& robot : {shaken, rolling, unseen, turning, changing}) {
    const Judged judged = judge(robot);
    EXPECT_FALSE(judged.bias) << robot.vibration << " " << robot.speed << " " << robot.radar_stands
                              << " " << robot.rate << " " << robot.ramp;
  }
  Config without_radar;
  without_radar.gpr.enabled = false;
  EXPECT_TRUE(judge(unseen, without_radar).bias);
}

// The wheel speed of a car, by a gyro on the wheel, has no sign and so a mean at rest.
TEST(Standstill, WheelWithinItsNoiseStands) {
  Robot car;
  car.radar_stands = false;
  car.speed = 0.011;
  EXPECT_FALSE(judge(car).standing);
  car.resting_wheel = 0.011;
  EXPECT_TRUE(judge(car).standing);
  car.speed = 0.05;
  EXPECT_FALSE(judge(car).standing);
}

TEST(Standstill, UnknownGyroBiasIsNotTakenForTurning) {
  Robot robot;
  robot.rate = 0.006;
  EXPECT_FALSE(judge(robot).standing);
  robot.bias_sigma = 0.005;
  EXPECT_TRUE(judge(robot).standing);
  robot.rate = 0.05;
  EXPECT_FALSE(judge(robot).standing);
}

// The last second of a car whose engine shakes it at rest, by another amount than before.
struct Car {
  double vibration = 1.8;  // of the noise at the standstill before
  double rate_step = 0.0;  // rad/s, in the last quarter
  double force_step = 0.0;
  double wheel = 0.011, wheel_lately = 0.011;  // m/s
  double estimated = 0.02;                     // m/s
  AtRest at_rest{kReference, 0.011, Eigen::Vector3d::Zero(), 1e-4, 0.0, true};
};

bool stands(const Car& car) {
  Noise noise(1);
  LastSecond last;
  constexpr double kAll_s = LastSecond::kBefore + LastSecond::kAfter;
  const int count = static_cast<int>(kAll_s * kImuRate);
  const double scale = car.vibration * std::sqrt(kImuRate);
  for (int i = 0; i < count; ++i) {
    ImuSample sample{from_seconds(i / kImuRate), {0, 0, 9.80665}, {0, 0, 0}};
    if (i > 0.75 * count) {
      sample.angular_velocity.y() += car.rate_step;
      sample.acceleration.x() += car.force_step;
    }
    noise.shake(sample, scale * kReference.accel_density, scale * kReference.gyro_density);
    last.imu.push_back(sample);
  }
  last.rolled_lately_m = car.wheel_lately * LastSecond::kLately;
  last.rolled_m = car.wheel * (kAll_s - LastSecond::kLately) + last.rolled_lately_m;
  last.estimated_mps = car.estimated;
  return stands_for_a_second(WheelConfig(), car.at_rest, Vibration(), last);
}

TEST(StandsForASecond, WithAnEngineThatRuns) {
  EXPECT_TRUE(stands({}));
  Car idles_otherwise;
  idles_otherwise.wheel = idles_otherwise.wheel_lately = 0.018;
  EXPECT_TRUE(stands(idles_otherwise));
  Car first_stop;  // after a start on the move
  first_stop.at_rest.known = false;
  first_stop.at_rest.wheel_mps = 0.0;
  first_stop.vibration = 10.0;
  EXPECT_TRUE(stands(first_stop));
}

TEST(StandsForASecond, NotWhatMoves) {
  Car rolls, brakes, sets_off, rocks, pushed, stuck_wheel, shaken, exact_wheel;
  rolls.wheel = rolls.wheel_lately = 0.03;
  brakes.wheel_lately = 0.0;
  sets_off.wheel_lately = 0.04;
  rocks.rate_step = 0.01;
  pushed.force_step = 0.3;
  stuck_wheel.wheel = stuck_wheel.wheel_lately = 0.0;
  stuck_wheel.estimated = 5.0;
  shaken.vibration = 5.0;
  exact_wheel.at_rest.wheel_mps = 0.0;  // it has shown no motion at rest
  for (const Car& car : {rolls, brakes, sets_off, rocks, pushed, stuck_wheel, shaken, exact_wheel})
    EXPECT_FALSE(stands(car)) << car.wheel << " " << car.wheel_lately << " " << car.rate_step << " "
                              << car.force_step << " " << car.estimated << " " << car.vibration;
}

}  // namespace
}  // namespace gprodom
