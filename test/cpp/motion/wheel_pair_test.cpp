#include "motion/wheel_pair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "motion/motion_judge.h"
#include "motion/turn_calibration.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kInterval = 0.2, kStep = 0.01;  // s
constexpr double kTrack = 0.5;                   // m

Config differential() {
  return default_config({"wheel.drive=differential", "wheel.track=" + std::to_string(kTrack)});
}

// A robot at 0.6 m/s in bends of 0.4 rad/s either way, its wheels at 50 Hz, ahead of the states.
class Drive {
 public:
  explicit Drive(const WheelConfig& config) : pair(config), wheel(config.max_speed) {}

  // The next interval. spin: m/s, of the left side beside rolling. silent: of the IMU.
  StateInput next(double spin = 0.0, bool silent = false) {
    const double from = now_;
    StateInput input;
    for (int i = 0; i < 20; ++i) {
      const double rate = 0.4 * std::sin(0.8 * now_);
      turned_ = rate * kStep;
      left_m_ += (0.6 - 0.5 * kTrack * rate + spin) * kStep;
      right_m_ += (0.6 + 0.5 * kTrack * rate) * kStep;
      now_ += kStep;
      MotionStep step;
      step.dt = kStep;
      step.angular_velocity.z() = silent ? 0.0 : rate;
      step.bridged = step.long_gap = silent;
      input.steps.push_back(step);
      turned_rad += turned_;
      if (i % 2 == 1) {
        const WheelsSample sample{from_seconds(now_), left_m_, right_m_};
        pair.insert(sample);
        wheel.insert({sample.time, 0.5 * (left_m_ + right_m_)});
      }
    }
    input.time = from_seconds(now_);
    input.wheel_contradicted = contradicted;
    input.has_wheel = set_wheel_distances(input.steps, wheel, from_seconds(from), false);
    pair.complete(input, from_seconds(from), NavState{}, wheel, ground_speed * kInterval);
    return input;
  }

  WheelPair pair;
  WheelHistory wheel;
  double turned_rad = 0.0;    // so far
  double ground_speed = 0.6;  // m/s, as published
  bool contradicted = false;  // by the slip watch

 private:
  double now_ = 100.0, left_m_ = 0.0, right_m_ = 0.0, turned_ = 0.0;
};

double wheel_turn(const StateInput& input) {
  double sum = 0.0;
  for (const MotionStep& step : input.steps) sum += step.gap_turn.value_or(0.0);
  return sum;
}

TEST(WheelPair, StandsInForASilentGyroAndOwnsUpToItsError) {
  Drive drive(differential().wheel);
  for (int i = 0; i < 300; ++i) EXPECT_EQ(wheel_turn(drive.next()), 0.0);
  const double before = drive.turned_rad;
  double told = 0.0, variance = 0.0;
  for (int i = 0; i < 50; ++i) {
    const StateInput input = drive.next(0.0, true);
    told += wheel_turn(input);
    variance += input.turn_variance;
  }
  EXPECT_NEAR(told, drive.turned_rad - before, 0.01);
  EXPECT_GT(std::sqrt(variance), 0.002);
  EXPECT_LT(std::sqrt(variance), 0.1);
}

TEST(WheelPair, GoesByTheOtherSideWhereOneSlips) {
  Drive drive(differential().wheel);
  for (int i = 0; i < 300; ++i) drive.next();
  EXPECT_EQ(drive.pair.slipping(), SlippingSide::kNone);
  for (const double spin : {0.4, -0.4}) {
    drive.next(spin);  // the step at its beginning lies between two samples
    const StateInput input = drive.next(spin);
    EXPECT_EQ(drive.pair.slipping(), SlippingSide::kLeft) << spin;
    double moved = 0.0;
    for (const MotionStep& step : input.steps) moved += step.wheel_m;
    EXPECT_NEAR(moved, 0.6 * kInterval, 0.003) << spin;
    EXPECT_FALSE(input.wheel_contradicted);
    for (int i = 0; i < 10; ++i) drive.next();
    EXPECT_EQ(drive.pair.slipping(), SlippingSide::kNone);
  }
}

// A slip of both sides by the same share would show in a bend.
TEST(WheelPair, VouchesInABendAgainstAPublishedVelocityThatIsWrong) {
  Drive drive(differential().wheel);
  for (int i = 0; i < 300; ++i) drive.next();
  drive.contradicted = true;
  drive.ground_speed = 0.25;
  int used = 0;
  for (int i = 0; i < 40; ++i) used += drive.next().wheel_contradicted ? 0 : 1;
  EXPECT_GT(used, 10);  // but not where the way is straight
  EXPECT_LT(used, 40);
  drive.ground_speed = 0.595;  // so small a slip would not show
  for (int i = 0; i < 10; ++i) drive.next();
  used = 0;
  for (int i = 0; i < 40; ++i) used += drive.next().wheel_contradicted ? 0 : 1;
  EXPECT_EQ(used, 0);
}

TEST(WheelPair, WheelsThatDoNotSlipHaveNoNoise) {
  Drive drive(differential().wheel);
  EXPECT_EQ(drive.pair.middle_noise(), 0.0);
  for (int i = 0; i < 300; ++i) drive.next();
  EXPECT_LT(drive.pair.middle_noise(), 0.005);  // wheels that do not slip at all
  EXPECT_EQ(WheelPair(WheelConfig{}).middle_noise(), 0.0);
}

// A judge that hears left and right wheels, after a start on the move.
class Judged {
 public:
  Judged() : judge(differential()) {
    newest_.state.time = from_seconds(kBegin);
    newest_.solve.usable = true;
    judge.begin(newest_, {newest_.state, {}, {1e-4, kAccelAtRest}, true});
  }

  // The sides go by side_mps against each other. shakes: m/s^2, of a sample. slip: m/sqrt(m), of
  // either side. sways: rad/s, to and fro every two seconds. The last answer.
  StateInput run(double seconds, double speed, double side_mps, double shakes, double slip = 0.0,
                 double sways = 0.0) {
    StateInput last;
    for (const int end = i_ + static_cast<int>(200 * seconds); i_ < end; ++i_) {
      const TimeNs time = from_seconds(kBegin + 0.005 * i_);
      ImuSample imu{time, {0, 0, 9.80665}, {0, 0, 0}};
      imu.acceleration += noise_.vector(shakes);
      imu.angular_velocity.z() = sways * std::sin(M_PI * 0.005 * i_);
      judge.add(imu);
      const double slipped = slip * std::sqrt(0.005 * speed);
      left_m_ += 0.005 * (speed - side_mps) + slipped * noise_();
      right_m_ += 0.005 * (speed + side_mps) + slipped * noise_();
      if (i_ % 4 == 0) judge.add(WheelsSample{time, left_m_, right_m_});
      if (i_ % 40 != 36 || i_ < 40) continue;
      newest_.state.time = time - 200'000'000;  // after the reorder window
      last = judge.judge(newest_.state.time);
      judge.adopt(newest_);
    }
    return last;
  }

  static constexpr double kAccelAtRest = 1e-3;  // m/s^2/sqrt(Hz), as told
  MotionJudge judge;

 private:
  static constexpr double kBegin = 100.0;  // s
  StateResult newest_;
  int i_ = 0;
  double left_m_ = 0.0, right_m_ = 0.0;
  Noise noise_{1};
};

// Its mean rate would be taken for the gyro's bias.
TEST(WheelPair, NeitherTurningOnTheSpotNorSwayingIsTheFirstRest) {
  for (const auto& [side_mps, sways] : {std::pair{0.0, 0.0}, {0.3, 0.0}, {0.0, 0.03}}) {
    Judged judged;
    judged.run(4.0, 0.6, 0.0, 0.5);
    judged.run(2.0, 0.0, side_mps, 0.05, 0.0, sways);
    const double learnt = judged.judge.noise_at_standstill().accel_density;
    EXPECT_EQ(learnt > 2 * Judged::kAccelAtRest, side_mps == 0.0 && sways == 0.0) << learnt;
  }
}

TEST(WheelPair, WhatItsSidesShowIsItsNoise) {
  constexpr double kSlip = 0.02;
  Judged judged;
  judged.run(10.0, 0.6, 0.0, 0.1, kSlip);
  EXPECT_EQ(judged.judge.pair().middle_noise(), 0.0);  // not enough yet
  judged.run(100.0, 0.6, 0.0, 0.1, kSlip);
  EXPECT_NEAR(judged.judge.pair().middle_noise(), kSlip / std::sqrt(2.0), 0.3 * kSlip);
}

TEST(WheelPair, SaysNothingForASingleDrive) {
  Drive drive(WheelConfig{});
  for (int i = 0; i < 100; ++i) drive.next();
  EXPECT_EQ(wheel_turn(drive.next(0.0, true)), 0.0);
  drive.next(0.4);
  EXPECT_EQ(drive.pair.slipping(), SlippingSide::kNone);
}

constexpr double kFloor = 5e-4;  // m

struct Robot {
  double track = 0.5, radii = 0.0;  // m; right over left, less one
  double slip = 0.01;               // m/sqrt(m), of right less left
};

struct Turned {
  PairMotion motion;
  double rad = 0.0;
};

// What the wheels report while the middle goes `middle_m` and the body turns by `rad`.
Turned move(const Robot& robot, double middle_m, double rad, std::mt19937& random) {
  std::normal_distribution<double> noise;
  const double path =
      std::abs(middle_m - 0.5 * robot.track * rad) + std::abs(middle_m + 0.5 * robot.track * rad);
  const double apart =
      robot.track * rad + robot.radii * middle_m + robot.slip * std::sqrt(path) * noise(random);
  return {{middle_m, apart, path}, rad};
}

// So many intervals at 0.6 m/s with bends either way of up to `bend` (rad/s).
void drive(const Robot& robot, int intervals, double bend, TurnCalibration& calibration,
           std::mt19937& random) {
  for (int i = 0; i < intervals; ++i) {
    const double rate = bend * std::sin(0.07 * i);
    const Turned turned = move(robot, 0.6 * kInterval, rate * kInterval, random);
    calibration.learn(turned.motion, turned.rad, kInterval);
  }
}

DriveTraits traits(WheelDrive drive, double track = 0.5) {
  WheelConfig config;
  config.drive = drive;
  config.track = track;
  return drive_traits(config);
}

TurnCalibration learnt(const Robot& robot, const DriveTraits& traits, int intervals, double bend,
                       std::mt19937& random) {
  TurnCalibration calibration(traits, kFloor);
  drive(robot, intervals, bend, calibration, random);
  return calibration;
}

// On other ground a skid steer's track is another; a differential drive's hardly is.
TEST(TurnCalibration, GoesOnFromARunBeforeAsFarAsThatHolds) {
  std::mt19937 random(3);
  for (const auto& [drive, room] :
       {std::pair(WheelDrive::kDifferential, 0.0025), std::pair(WheelDrive::kSkidSteer, 0.075)}) {
    const Robot robot{1.03 * traits(drive).track_m, 0.01};
    const TurnCalibration before = learnt(robot, traits(drive), 1000, 0.6, random);
    TurnCalibration after(traits(drive), kFloor);
    const double radii_at_first = after.radii_difference_sigma();
    after.resume(before.learnt());
    EXPECT_EQ(after.track_m(), before.track_m());
    EXPECT_EQ(after.radii_difference(), before.radii_difference());
    EXPECT_GT(after.track_sigma_m(), room);
    EXPECT_LT(after.track_sigma_m(), std::hypot(before.track_sigma_m(), 1.01 * room));
    EXPECT_GT(after.radii_difference_sigma(), before.radii_difference_sigma());
    EXPECT_LT(after.radii_difference_sigma(), radii_at_first);

    TurnCalibration untaught(traits(drive), kFloor), fresh(traits(drive), kFloor);
    fresh.resume({2.0, 10.0, 0.1, 1.0});  // a run that learnt nothing
    EXPECT_EQ(fresh.track_m(), untaught.track_m());
    EXPECT_EQ(fresh.track_sigma_m(), untaught.track_sigma_m());
    EXPECT_EQ(fresh.radii_difference(), 0.0);
  }
}

TEST(TurnCalibration, FindsTrackAndRadiiWithinItsSigmas) {
  double track_nees = 0.0, radii_nees = 0.0;
  constexpr int kDrives = 50;
  for (int seed = 0; seed < kDrives; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise;
    const Robot robot{0.5 * (1 + 0.05 * noise(random)), 0.02 * noise(random)};
    TurnCalibration calibration(traits(WheelDrive::kDifferential), kFloor);
    EXPECT_EQ(calibration.measured_noise_per_middle(), 0.0);
    drive(robot, 1000, 0.6, calibration, random);
    EXPECT_NEAR(calibration.track_m(), robot.track, 0.02 * robot.track) << seed;
    EXPECT_NEAR(calibration.noise(), robot.slip, 0.3 * robot.slip) << seed;
    EXPECT_NEAR(calibration.measured_noise_per_middle() / std::sqrt(2.0), robot.slip,
                0.3 * robot.slip);
    track_nees += std::pow((calibration.track_m() - robot.track) / calibration.track_sigma_m(), 2);
    radii_nees += std::pow(
        (calibration.radii_difference() - robot.radii) / calibration.radii_difference_sigma(), 2);
  }
  // 50 squares of unit variance lie between 0.6 and 1.5 on the mean (3 sigma); walks that are
  // allowed for and did not happen make them smaller.
  EXPECT_LT(track_nees / kDrives, 1.5);
  EXPECT_LT(radii_nees / kDrives, 1.5);
  EXPECT_GT(track_nees / kDrives, 0.3);
}

// Regressed the other way round, slip would make it wider.
TEST(TurnCalibration, SlipDoesNotWidenTheTrack) {
  std::mt19937 random(3);
  const Robot robot{1.8, 0.0, 0.15};
  const auto calibration = learnt(robot, traits(WheelDrive::kSkidSteer, 1.0), 5000, 0.5, random);
  EXPECT_NEAR(calibration.track_m(), robot.track, 0.04 * robot.track);
}

TEST(TurnCalibration, HoldsWhatAStraightWayDoesNotShow) {
  std::mt19937 random(4);
  const Robot robot{0.55, 0.01};
  TurnCalibration calibration(traits(WheelDrive::kDifferential), kFloor);
  const double sigma = calibration.track_sigma_m();
  drive(robot, 2000, 0.0, calibration, random);
  EXPECT_NEAR(calibration.track_m(), 0.5, 1e-6);
  EXPECT_GE(calibration.track_sigma_m(), 0.999 * sigma);
  EXPECT_NEAR(calibration.radii_difference(), robot.radii, 0.003);
}

TEST(TurnCalibration, OneThatSpinsIsOutvoted) {
  std::mt19937 random(5);
  const Robot robot{0.5, 0.0};
  auto calibration = learnt(robot, traits(WheelDrive::kDifferential), 1000, 0.6, random);
  for (int i = 0; i < 20; ++i) {  // 4 s in which the right side goes 0.3 m/s faster
    Turned turned = move(robot, 0.6 * kInterval, 0.1 * kInterval, random);
    turned.motion.difference_m += 0.3 * kInterval;
    calibration.learn(turned.motion, turned.rad, kInterval);
  }
  EXPECT_NEAR(calibration.track_m(), 0.5, 0.02);
}

// The variance of the turn that left and right tell over ten seconds, after a drive that taught
// them: squares over it are one on the mean.
TEST(TurnCalibration, OwnsUpToTheTurnsError) {
  double nees = 0.0;
  constexpr int kDrives = 200;
  for (int seed = 0; seed < kDrives; ++seed) {
    std::mt19937 random(seed);
    const Robot robot{0.51, 0.005};
    const auto calibration = learnt(robot, traits(WheelDrive::kDifferential), 300, 0.6, random);
    PairMotion told;
    double true_rad = 0.0;
    for (int i = 0; i < 50; ++i) {
      const Turned turned = move(robot, 0.6 * kInterval, 0.3 * kInterval, random);
      told += turned.motion;
      true_rad += turned.rad;
    }
    nees += std::pow(calibration.turn(told) - true_rad, 2) / calibration.turn_variance(told);
  }
  EXPECT_GT(nees / kDrives, 0.6);
  EXPECT_LT(nees / kDrives, 1.4);
}

}  // namespace
}  // namespace gprodom
