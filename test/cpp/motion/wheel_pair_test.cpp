#include "motion/wheel_pair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/motion_judge.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kInterval = 0.2, kStep = 0.01;  // s
constexpr double kTrack = 0.5;                   // m

WheelConfig differential() {
  WheelConfig config;
  config.drive = WheelDrive::kDifferential;
  config.track = kTrack;
  return config;
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
  Drive drive(differential());
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
  Drive drive(differential());
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
  Drive drive(differential());
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
  Drive drive(differential());
  EXPECT_EQ(drive.pair.middle_noise(), 0.0);
  for (int i = 0; i < 300; ++i) drive.next();
  EXPECT_LT(drive.pair.middle_noise(), 0.005);  // wheels that do not slip at all
  EXPECT_EQ(WheelPair(WheelConfig{}).middle_noise(), 0.0);
}

// A judge that hears left and right wheels, after a start on the move.
class Judged {
 public:
  Judged() : judge(config()) {
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
  static Config config() {
    Config config;
    config.wheel = differential();
    return config;
  }
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

}  // namespace
}  // namespace gprodom
