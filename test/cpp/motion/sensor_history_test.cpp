// What the wheel's history says of a time, and where it says nothing: outside its data, across a
// jump of the count, across a gap.
#include "motion/history/sensor_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace gprodom {
namespace {

constexpr double kMaxSpeed = 2.0;  // m/s
constexpr double kPeriod = 0.1;    // s, between samples

// Samples at 100.0, 100.1, ... s of a wheel at 1 m/s, whose count is 7 m at the first.
WheelHistory even_drive(int samples) {
  WheelHistory wheel(kMaxSpeed);
  for (int i = 0; i < samples; ++i)
    EXPECT_TRUE(wheel.insert({from_seconds(100 + i * kPeriod), 7 + i * kPeriod}));
  return wheel;
}

std::optional<double> distance(const WheelHistory& wheel, double from, double to,
                               bool across_gaps = false) {
  const auto a = wheel.distance(from_seconds(from), across_gaps);
  const auto b = wheel.distance(from_seconds(to), across_gaps);
  return a && b ? std::optional(*b - *a) : std::nullopt;
}

void expect_m(const std::optional<double>& metres, double expected) {
  ASSERT_TRUE(metres);
  EXPECT_NEAR(*metres, expected, 1e-9);
}

TEST(WheelHistory, InterpolatesBetweenSamplesOnly) {
  const WheelHistory wheel = even_drive(4);
  expect_m(distance(wheel, 100.0, 100.3), 0.3);
  expect_m(distance(wheel, 100.02, 100.17), 0.15);
  expect_m(wheel.reported(from_seconds(100.17)), 7.17);
  EXPECT_FALSE(wheel.distance(from_seconds(99.99)));
  EXPECT_FALSE(wheel.distance(from_seconds(100.31)));
  EXPECT_FALSE(WheelHistory(kMaxSpeed).distance(0));
}

TEST(WheelHistory, JumpOfTheCountIsNotCounted) {
  for (const double jump : {30.0, -7.4}) {  // the second: set to zero
    WheelHistory wheel = even_drive(5);
    EXPECT_FALSE(wheel.insert({from_seconds(100.5), 7.4 + jump}));
    EXPECT_TRUE(wheel.insert({from_seconds(100.6), 7.5 + jump}));
    EXPECT_FALSE(wheel.distance(from_seconds(100.45)));
    EXPECT_FALSE(wheel.reported(from_seconds(100.45)));
    EXPECT_FALSE(wheel.distance(from_seconds(100.45), true));
    expect_m(distance(wheel, 100.0, 100.5), 0.4);
    expect_m(distance(wheel, 100.4, 100.6), 0.1);
    expect_m(wheel.reported(from_seconds(100.6)), 7.5 + jump);
    EXPECT_NEAR(wheel.path(from_seconds(100.0), from_seconds(100.6)), 0.5, 1e-9);
  }
}

TEST(WheelHistory, SpeedUpToTheLimitIsAccepted) {
  for (const double sign : {1.0, -1.0}) {
    // Two metres a second for 0.1 s, and for the 20 ms by which a stamp may be off.
    WheelHistory wheel = even_drive(1);
    EXPECT_TRUE(wheel.insert({from_seconds(100.1), 7 + sign * 0.239}));
    EXPECT_FALSE(wheel.insert({from_seconds(100.2), 7 + sign * (0.239 + 0.241)}));
  }
}

TEST(WheelHistory, LateSampleIsInsertedByItsStamp) {
  WheelHistory wheel(kMaxSpeed);
  wheel.insert({from_seconds(100.0), 7.0});
  wheel.insert({from_seconds(100.2), 7.2});
  expect_m(distance(wheel, 100.0, 100.1), 0.1);
  EXPECT_TRUE(wheel.insert({from_seconds(100.1), 7.15}));
  expect_m(distance(wheel, 100.0, 100.1), 0.15);
  expect_m(distance(wheel, 100.0, 100.2), 0.2);
  EXPECT_TRUE(wheel.insert({from_seconds(99.9), 6.95}));  // before all others
  expect_m(distance(wheel, 99.9, 100.2), 0.25);
}

TEST(WheelHistory, LateSampleBeforeAllOthersKeepsTheDistance) {
  WheelHistory wheel = even_drive(2);
  EXPECT_FALSE(wheel.insert({from_seconds(100.2), 50.0}));  // count and distance differ from here
  wheel.forget_before(from_seconds(100.2));
  EXPECT_TRUE(wheel.insert({from_seconds(100.1), 49.9}));
  expect_m(distance(wheel, 100.1, 100.2), 0.1);
}

TEST(WheelHistory, LateSampleClosesAGap) {
  WheelHistory wheel = even_drive(1);
  wheel.insert({from_seconds(100.4), 7.4});
  EXPECT_FALSE(wheel.distance(from_seconds(100.1)));
  EXPECT_TRUE(wheel.insert({from_seconds(100.2), 7.3}));
  expect_m(distance(wheel, 100.0, 100.1), 0.15);
}

TEST(WheelHistory, GapIsSpannedOnlyOnRequest) {
  WheelHistory wheel = even_drive(3);
  EXPECT_TRUE(wheel.insert({from_seconds(101.2), 8.2}));
  EXPECT_FALSE(distance(wheel, 100.1, 100.7));
  expect_m(distance(wheel, 100.1, 100.7, true), 0.6);
  expect_m(distance(wheel, 100.0, 101.2), 1.2);  // at samples its ends are known
  EXPECT_FALSE(wheel.reported(from_seconds(100.7)));
}

TEST(WheelHistory, FirstGapAfterAResumeIsSpannedAtAnyLength) {
  WheelHistory wheel = even_drive(3);
  wheel.resume({from_seconds(200), 50.0});
  EXPECT_FALSE(wheel.distance(from_seconds(100.1)));  // of the run before
  EXPECT_TRUE(wheel.insert({from_seconds(220), 60.0}));
  expect_m(distance(wheel, 200, 210), 5.0);
  EXPECT_TRUE(wheel.insert({from_seconds(230), 65.0}));
  EXPECT_FALSE(wheel.distance(from_seconds(225)));  // a gap like any other
}

TEST(WheelHistory, CountResetToZeroAfterAResumeIsAJump) {
  WheelHistory wheel(kMaxSpeed);
  wheel.resume({from_seconds(200), 50.0});
  EXPECT_FALSE(wheel.insert({from_seconds(210), 0.0}));
  EXPECT_FALSE(wheel.distance(from_seconds(205)));
  EXPECT_TRUE(wheel.insert({from_seconds(210.1), 0.1}));
  expect_m(distance(wheel, 200, 210.1), 0.1);
}

TEST(WheelHistory, ForgettingKeepsTheSampleToInterpolateFrom) {
  WheelHistory wheel = even_drive(6);
  wheel.forget_before(from_seconds(100.25));
  expect_m(distance(wheel, 100.25, 100.5), 0.25);
  expect_m(distance(wheel, 100.2, 100.5), 0.3);
  EXPECT_FALSE(wheel.distance(from_seconds(100.19)));
}

TEST(WheelHistory, ThePathIsUnsigned) {
  WheelHistory wheel(kMaxSpeed);
  for (int i = 0; i < 4; ++i)
    wheel.insert({from_seconds(100 + i * kPeriod), i % 2 == 0 ? 0.0 : 0.1});
  EXPECT_NEAR(wheel.path(from_seconds(100), from_seconds(100.3)), 0.3, 1e-9);
  EXPECT_NEAR(wheel.path(from_seconds(100.1), from_seconds(100.2)), 0.2, 1e-9);
  EXPECT_EQ(wheel.path(from_seconds(101), from_seconds(102)), 0.0);
}

TEST(WheelDistances, AreAssignedToTheirSteps) {
  WheelHistory wheel(kMaxSpeed);
  wheel.insert({from_seconds(100.0), 0.0});
  wheel.insert({from_seconds(100.1), 0.1});
  wheel.insert({from_seconds(100.2), 0.05});
  std::vector<MotionStep> steps(4);
  for (MotionStep& step : steps) step.dt = 0.05;
  ASSERT_TRUE(set_wheel_distances(steps, wheel, from_seconds(100), false));
  const double expected[] = {0.05, 0.05, -0.025, -0.025};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(steps[i].wheel_m, expected[i], 1e-9);
}

TEST(WheelDistances, AreAllZeroWhereTheWheelDoesNotCoverThemAll) {
  const WheelHistory wheel = even_drive(3);  // to 100.2 s
  std::vector<MotionStep> steps(5);
  for (MotionStep& step : steps) step.dt = 0.05;
  EXPECT_FALSE(set_wheel_distances(steps, wheel, from_seconds(100), true));
  for (const MotionStep& step : steps) EXPECT_EQ(step.wheel_m, 0.0);
  std::vector<MotionStep> none;
  EXPECT_FALSE(set_wheel_distances(none, wheel, from_seconds(100), true));
}

// A car that drives faster than a wheel of which nothing is known may turn: gradually, or so from
// its first sample on. One sample alone is a jump all the same.
TEST(WheelHistory, FastVehicleIsAccepted) {
  WheelHistory wheel(kMaxSpeed);
  double metres = 0, speed = 0;
  int dropped = 0;
  for (int i = 0; i < 200; ++i) {
    metres += kPeriod * speed;
    dropped += !wheel.insert({from_seconds(100 + i * kPeriod), metres});
    speed = std::min(20.0, speed + kPeriod * 3.0);
  }
  EXPECT_EQ(dropped, 0);
  EXPECT_FALSE(wheel.insert({from_seconds(120.0), metres + 100}));

  WheelHistory late(kMaxSpeed);
  dropped = 0;
  for (int i = 0; i < 50; ++i)
    dropped += !late.insert({from_seconds(100 + i * kPeriod), 20 * i * kPeriod});
  EXPECT_LE(dropped, 6);
}

// What is told of the jumps of a wheel at this speed (m/s), heard from there on.
int jumps_told(WheelHistory& wheel, double speed) {
  int told = 0;
  for (int i = 0; i < 50; ++i) {
    wheel.insert({from_seconds(100 + i * kPeriod), speed * i * kPeriod});
    told += wheel.take_jump();
  }
  return told;
}

TEST(WheelHistory, SpeedThatIsLearntIsNotToldAsAJump) {
  for (const double speed : {0.5, 8.0, 30.0}) {
    WheelHistory wheel(0.0);
    EXPECT_EQ(jumps_told(wheel, speed), 0) << speed;
    for (const double jump : {100.0, -100.0}) {
      const double time = jump > 0 ? 105.0 : 105.2, metres = speed * (time - 100.0);
      EXPECT_FALSE(wheel.insert({from_seconds(time), metres + std::max(0.0, jump)}));
      EXPECT_FALSE(wheel.take_jump()) << "the first of several such increments, or a jump?";
      wheel.insert({from_seconds(time + kPeriod), metres + std::max(0.0, jump) + speed * kPeriod});
      EXPECT_TRUE(wheel.take_jump());
    }
    EXPECT_FALSE(wheel.take_jump());
  }
}

TEST(WheelHistory, SpeedBeyondAGivenLimitIsTold) {
  WheelHistory slow(5.0), fast(5.0);
  EXPECT_EQ(jumps_told(slow, 4.0), 0);
  EXPECT_GT(jumps_told(fast, 8.0), 0);
}

// Of a busy computer: stamps come up to a period early or late, but every count is right.
TEST(WheelHistory, NothingIsLostWhereStampsComeCloseTogether) {
  constexpr double kPeriod_s = 0.05, kSpeed_mps = 12.0;
  WheelHistory wheel(kMaxSpeed);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> off(-0.6 * kPeriod_s, 0.6 * kPeriod_s);
  double metres = 0.0, stamp = 0.0;
  int dropped = 0;
  for (int i = 0; i < 400; ++i) {
    metres += kPeriod_s * std::min(kSpeed_mps, 0.1 * i);
    const double late = i < 150 ? 0.0 : off(random);
    stamp = std::max(stamp + 1e-4, 100 + i * kPeriod_s + late);  // in the order of the counts
    dropped += !wheel.insert({from_seconds(stamp), metres});
  }
  EXPECT_EQ(dropped, 0);
  EXPECT_FALSE(wheel.insert({from_seconds(100 + 400 * kPeriod_s), metres + 10}));
}

TEST(WheelHistory, MeasuresHowLongAValueIsRepeated) {
  for (const int repeats : {1, 5}) {
    WheelHistory wheel(5.0);
    double metres = 0;
    for (int i = 0; i < 1000; ++i) {
      metres += 0.05 * (1.0 + 0.5 * std::sin(0.3 * (i / repeats)));
      wheel.insert({from_seconds(100 + i * 0.05), metres});
    }
    EXPECT_NEAR(wheel.held_s(), 0.05 * (repeats - 1), 0.03) << repeats;
  }
}

// Two lost samples of a slow IMU are none, those of as long a time of a fast one are.
TEST(ImuHistory, AGapIsLongerForASlowImu) {
  const auto bridged = [](double rate, double lost_s) {
    ImuHistory imu;
    for (int i = 0; i < 20 * rate; ++i) {
      ImuSample sample;
      sample.time = from_seconds(i / rate + (i > 10 * rate ? lost_s : 0.0));
      imu.insert(sample);
    }
    const auto steps = imu.steps(from_seconds(9.0), from_seconds(12.0));
    return std::any_of(steps.begin(), steps.end(), [](const MotionStep& s) { return s.bridged; });
  };
  EXPECT_FALSE(bridged(10.0, 0.18));
  EXPECT_FALSE(bridged(20.0, 0.1));
  EXPECT_TRUE(bridged(20.0, 0.2));
  EXPECT_TRUE(bridged(100.0, 0.15));
  EXPECT_TRUE(bridged(10.0, 0.25)) << "longer than values are interpolated";
}

}  // namespace
}  // namespace gprodom
