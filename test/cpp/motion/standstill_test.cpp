// Conditions for a standstill, and for a step of the gyro bias: a steady rate while all other
// sensors show a standstill, and no other case.
#include "motion/rest/standstill.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/rest/imu_noise.h"
#include "motion/rest/rest_levels.h"
#include "motion/rest/vibration.h"
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

// A robot that differs in one thing, or in one more.
template <class T>
Robot with(T Robot::*what, T value, Robot robot = {}) {
  robot.*what = value;
  return robot;
}

TEST(Standstill, StillImuAndEitherWheelOrRadarAreEnough) {
  const Robot spinning_wheel = with(&Robot::speed, 0.3);
  EXPECT_TRUE(judge({}).standing);
  EXPECT_TRUE(judge(with(&Robot::radar_stands, false)).standing);
  EXPECT_TRUE(judge(spinning_wheel).standing);
  EXPECT_FALSE(judge(with(&Robot::radar_stands, false, spinning_wheel)).standing);
  EXPECT_FALSE(judge(with(&Robot::vibration, 5.0)).standing);
}

// Two or three samples between two states show no vibration: those before count as well.
TEST(Standstill, ASlowImuShowsIt) {
  for (const double rate : {10.0, 18.0}) {
    const Robot robot = with(&Robot::radar_stands, false, with(&Robot::imu_rate, rate));
    EXPECT_GT(judge(robot).share, 0.7) << rate;
    EXPECT_EQ(judge(with(&Robot::vibration, 3.0, robot)).share, 0.0) << rate;
    EXPECT_EQ(judge(with(&Robot::rate, 0.02, robot)).share, 0.0) << rate;
  }
}

// A robot that starts to creep, over ground on which the radar cannot see such slow motion.
TEST(Standstill, RadarDoesNotContradictAWheelBelowItsSight) {
  EXPECT_TRUE(judge(with(&Robot::speed, 0.04)).standing);
  const Robot creeping = with(&Robot::unseen, 0.05);
  EXPECT_FALSE(judge(with(&Robot::speed, 0.04, creeping)).standing);
  EXPECT_TRUE(judge(with(&Robot::speed, 0.06, creeping)).standing);
  EXPECT_TRUE(judge(creeping).standing);
}

TEST(BiasWatch, SteadyRateAtAStandstillIsTheBias) {
  for (const double rate : {5e-3, 0.02, 0.04}) {
    const Judged judged = judge(with(&Robot::rate, rate));
    EXPECT_FALSE(judged.standing);
    EXPECT_TRUE(judged.steady);
    EXPECT_FALSE(judged.turns);
    ASSERT_TRUE(judged.bias) << rate;
    EXPECT_LT((*judged.bias - Eigen::Vector3d(0, 0, rate)).norm(), 5e-4);  // over a second
  }
}

TEST(BiasWatch, OtherRatesAreNotTheBias) {
  EXPECT_FALSE(judge({}).bias);
  const Robot stepped = with(&Robot::rate, 5e-3), turning = with(&Robot::rate, 0.1),
              unseen = with(&Robot::radar_stands, false, stepped);
  for (const Robot& robot : {with(&Robot::vibration, 5.0, stepped), unseen, turning,
                             with(&Robot::speed, 0.3, stepped), with(&Robot::ramp, 0.02, stepped)})
    EXPECT_FALSE(judge(robot).bias) << robot.vibration << " " << robot.speed << " " << robot.rate
                                    << " " << robot.radar_stands << " " << robot.ramp;
  EXPECT_TRUE(judge(turning).turns);
  EXPECT_FALSE(judge(with(&Robot::vibration, 5.0, turning)).turns);
  Config without_radar;
  without_radar.gpr.enabled = false;
  EXPECT_TRUE(judge(unseen, without_radar).bias);
}

// The wheel speed of a car, by a gyro on the wheel, has no sign and so a mean at rest.
TEST(Standstill, WheelWithinItsNoiseStands) {
  const Robot car = with(&Robot::radar_stands, false);
  EXPECT_FALSE(judge(with(&Robot::speed, 0.011, car)).standing);
  const Robot known = with(&Robot::resting_wheel, 0.011, car);
  EXPECT_TRUE(judge(with(&Robot::speed, 0.011, known)).standing);
  EXPECT_FALSE(judge(with(&Robot::speed, 0.05, known)).standing);
}

TEST(Standstill, UnknownGyroBiasIsNotTakenForTurning) {
  EXPECT_FALSE(judge(with(&Robot::rate, 0.006)).standing);
  const Robot unknown = with(&Robot::bias_sigma, 0.005);
  EXPECT_TRUE(judge(with(&Robot::rate, 0.006, unknown)).standing);
  EXPECT_FALSE(judge(with(&Robot::rate, 0.05, unknown)).standing);
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
  Car exact_wheel;
  exact_wheel.at_rest.wheel_mps = 0.0;  // it has shown no motion at rest
  EXPECT_FALSE(stands(exact_wheel));
  const Car rolls{1.8, 0, 0, 0.03, 0.03}, brakes{1.8, 0, 0, 0.011, 0.0},
      sets_off{1.8, 0, 0, 0.011, 0.04}, rocks{1.8, 0.01}, pushed{1.8, 0.0, 0.3}, shaken{5.0},
      stuck_wheel{1.8, 0, 0, 0.0, 0.0, 5.0};
  for (const Car& car : {rolls, brakes, sets_off, rocks, pushed, stuck_wheel, shaken})
    EXPECT_FALSE(stands(car)) << car.wheel << " " << car.wheel_lately << " " << car.rate_step << " "
                              << car.force_step << " " << car.estimated << " " << car.vibration;
}

// Levels at rest: measured at the start, or from the quietest second after a start on the move.

std::vector<ImuSample> second(double vibration, int rate = 200) {  // Hz
  Noise noise(1);
  std::vector<ImuSample> samples;
  const double scale = vibration * std::sqrt(static_cast<double>(rate));
  for (int i = 0; i < rate; ++i) {
    ImuSample sample{from_seconds(1.0 * i / rate), {0, 0, 9.80665}, {0, 0, 0}};
    noise.shake(sample, scale * kReference.accel_density, scale * kReference.gyro_density);
    samples.push_back(sample);
  }
  return samples;
}

double times_own(const RestLevels& rest) {
  return rest.noise().accel_density / kReference.accel_density;
}

TEST(ImuNoise, IsADensityAtAnySampleRate) {
  for (const int rate : {25, 400}) {
    const ImuNoise noise = measured_noise(second(5.0, rate));
    EXPECT_NEAR(noise.accel_density / kReference.accel_density, 5.0, 1.5) << rate;
    EXPECT_NEAR(noise.gyro_density / kReference.gyro_density, 5.0, 1.5) << rate;
  }
}

TEST(RestLevels, AfterAStartOnTheMoveTheQuietestSecondCounts) {
  RestLevels rest;
  rest.begin({NavState(), {}, kReference, true});
  EXPECT_FALSE(rest.known());
  rest.stood(second(10.0), 0.0);  // the body rocks
  EXPECT_TRUE(rest.known());
  EXPECT_NEAR(times_own(rest), 10.0, 1.0);
  rest.stood(second(3.0), 0.011);
  EXPECT_NEAR(times_own(rest), 3.0, 0.3);
  rest.stood(second(5.0), 0.1);
  EXPECT_NEAR(times_own(rest), 3.0, 0.3);
  EXPECT_EQ(rest.wheel_mps(), 0.011);  // the robot sets off: its wheel does not count
  rest.stood(second(0.1), 0.0);
  EXPECT_EQ(times_own(rest), 1.0);  // never below the sensor's own
}

TEST(RestLevels, AStandstillAtTheStartIsKept) {
  RestLevels rest;
  rest.measure(second(2.0), 0.011);
  rest.begin({NavState(), {}, kReference, false});
  EXPECT_TRUE(rest.known());
  EXPECT_EQ(times_own(rest), 1.0);
  EXPECT_NEAR(rest.vibration().accel_density, 2 * kReference.accel_density,
              0.2 * kReference.accel_density);
  rest.stood(second(0.5), 0.02);
  EXPECT_EQ(times_own(rest), 1.0);
  EXPECT_EQ(rest.wheel_mps(), 0.011);
}

// When the IMU's vibration tells standing from driving, and when it does not.
ImuNoise times(double factor) {
  return {factor * kReference.gyro_density, factor * kReference.accel_density};
}

Vibration after_driving(const ImuNoise& level) {
  Vibration vibration;
  for (int i = 0; i < 100; ++i) vibration.drives(level);
  return vibration;
}

TEST(Vibration, AnEngineHidesRestAndElectricMotorsDoNot) {
  EXPECT_TRUE(after_driving(times(1.2)).hides_rest(times(1.5), kReference));
  EXPECT_FALSE(after_driving(times(5.0)).hides_rest(times(1.5), kReference));
}

TEST(Vibration, OneSensorThatTellsIsEnough) {
  const Vibration by_accel = after_driving({kReference.gyro_density, 5 * kReference.accel_density});
  EXPECT_FALSE(by_accel.hides_rest(times(1.5), kReference));
  const Vibration by_gyro = after_driving({5 * kReference.gyro_density, kReference.accel_density});
  EXPECT_FALSE(by_gyro.hides_rest(times(1.5), kReference));
}

// Some of the driving is as quiet as a standstill: in the low tenth.
TEST(Vibration, QuietMomentsOfDrivingCount) {
  Vibration vibration;
  for (int i = 0; i < 100; ++i) vibration.drives(times(i % 5 == 0 ? 1.0 : 5.0));
  EXPECT_TRUE(vibration.hides_rest(times(1.5), kReference));
}

TEST(Vibration, BeforeDrivingHasShownItsLevelAnEngineMayVaryByTwo) {
  const Vibration vibration;
  EXPECT_TRUE(vibration.hides_rest(times(1.9), kReference));
  EXPECT_FALSE(vibration.hides_rest(times(2.1), kReference));
}

TEST(Vibration, FarBelowDrivingIsLessThanHalfOfIt) {
  EXPECT_FALSE(Vibration().far_below_driving(times(0.1)));
  EXPECT_TRUE(after_driving(times(5.0)).far_below_driving(times(2.0)));
  EXPECT_FALSE(after_driving(times(5.0)).far_below_driving(times(3.0)));
}

TEST(Vibration, WithoutAnEarlierStandstillItTellsNothing) {
  EXPECT_TRUE(after_driving(times(5.0)).hides_rest(times(1.5), std::nullopt));
}

}  // namespace
}  // namespace gprodom
