#include "input/time_guard.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace gprodom {
namespace {

constexpr TimeNs kMs = 1'000'000, kStart = 1'700'000'000'000'000'000;

std::string check(TimeGuard& guard, TimeGuard::Source source, TimeNs time) {
  return guard.check(source, time);
}

// The IMU at 100 Hz and the wheel at 20 Hz, both with the robot's clock, for a while.
class Clock {
 public:
  TimeNs now = kStart;
  TimeGuard guard{TimeConfig{}};
  TimeGuard::Source wheel_source = TimeGuard::kWheel;

  void run(int seconds, bool imu = true, bool wheel = true) {
    for (int i = 0; i < 100 * seconds; ++i) {
      now += 10 * kMs;
      if (imu) taken_imu += check(guard, TimeGuard::kImu, now).empty();
      if (wheel && i % 5 == 0) taken_wheel += check(guard, wheel_source, now + kMs).empty();
    }
  }
  int taken_imu = 0, taken_wheel = 0;
};

TEST(TimeGuard, OneWrongStampDropsOneMessageOnly) {
  for (const TimeNs wrong : {-1000 * kMs, 1000 * kMs, 4000 * kMs, 3600'000 * kMs}) {
    for (const auto source : {TimeGuard::kImu, TimeGuard::kWheel}) {
      Clock clock;
      clock.run(2);
      EXPECT_NE(check(clock.guard, source, clock.now + wrong), "");
      const int imu = clock.taken_imu, wheel = clock.taken_wheel;
      clock.run(2);
      EXPECT_EQ(clock.taken_imu - imu, 200) << wrong;
      EXPECT_EQ(clock.taken_wheel - wheel, 40) << wrong;
      EXPECT_FALSE(clock.guard.moved());
    }
  }
}

// A sensor with a wrong clock is not used, and it does not make the IMU's messages look late.
TEST(TimeGuard, WrongClockOfAnotherSensorDoesNotStopTheImu) {
  for (const TimeNs off : {1000 * kMs, 3600'000 * kMs, -1000 * kMs}) {
    Clock clock;
    clock.run(1);
    for (int i = 0; i < 1000; ++i) {
      clock.now += 10 * kMs;
      ASSERT_EQ(check(clock.guard, TimeGuard::kImu, clock.now), "");
      ASSERT_NE(check(clock.guard, TimeGuard::kGpr, clock.now + off), "");
    }
  }
}

TEST(TimeGuard, OtherSensorsContinueWhileTheImuIsSilentAndItReturns) {
  Clock clock;
  clock.run(1);
  const int before = clock.taken_wheel;
  clock.run(60, false);
  EXPECT_GT(clock.taken_wheel - before, 60 * 20 - 5);
  clock.run(1);
  EXPECT_EQ(clock.taken_imu, 200);
  EXPECT_FALSE(clock.guard.moved());
}

TEST(TimeGuard, PauseOfAllSensorsIsAcceptedUpToMaxJump) {
  Clock clock;
  clock.run(1);
  clock.now += 3000 * kMs;
  clock.run(1);
  EXPECT_GE(clock.taken_imu, 197);
  EXPECT_FALSE(clock.guard.moved());
}

// All sensors fall silent together for longer than kMaxJump. The robot may have driven on, so the
// time must not be continued as after a clock that was set.
TEST(TimeGuard, SilenceOfAllSensorsIsNoClockSetAhead) {
  Clock clock;
  clock.run(1);
  clock.now += 10'000 * kMs;
  clock.run(1);
  EXPECT_GE(clock.taken_imu, 185);
  EXPECT_FALSE(clock.guard.moved());
  EXPECT_EQ(clock.guard.sensor_stamp(clock.now), clock.now);
  TimeNs next = clock.now + 10 * kMs;
  EXPECT_EQ(check(clock.guard, TimeGuard::kImu, next), "");
}

// After such a silence an IMU of 250 Hz is heard 50 times before a wheel of 2 Hz is heard once.
TEST(TimeGuard, SilenceOfAllSensorsIsNoClockOfAFastImuSetAhead) {
  for (const bool wheel_returns : {true, false}) {
    TimeGuard guard{TimeConfig{}};
    int taken = 0;
    for (int i = 0; i < 5000; ++i) {
      const TimeNs now = kStart + 4 * i * kMs + (i >= 1000 ? 10'000 * kMs : 0);
      if (check(guard, TimeGuard::kImu, now).empty()) ++taken;
      if (i % 125 == 124 && (i < 1000 || wheel_returns)) check(guard, TimeGuard::kWheel, now);
      ASSERT_FALSE(guard.moved()) << i;
    }
    EXPECT_GT(taken, 4700);
  }
}

// No other sensor tells the time, and the gap would be too long to be bridged.
TEST(TimeGuard, FarAheadWithNoOtherSensorTheEstimatorRestarts) {
  Clock clock;
  clock.run(1, true, false);
  clock.now += 3600'000 * kMs;
  clock.run(2, true, false);
  EXPECT_TRUE(clock.guard.moved());
}

// The clock of one sensor is set, by much or little, ahead or back. The time goes on with the
// other; but stamps that come late are no clock that was set.
TEST(TimeGuard, ClockOfOneSensorSetAloneIsCarriedOn) {
  for (const auto source : {TimeGuard::kImu, TimeGuard::kWheel}) {
    for (const TimeNs by : {-3600'000, -10'000, -1000, 1000, 10'000, 3600'000}) {
      Clock clock;
      clock.run(2);
      TimeNs newest = clock.now;
      int taken = 0, told = 0;
      for (int i = 0; i < 400; ++i) {
        clock.now += 10 * kMs;
        for (const auto each : {TimeGuard::kImu, TimeGuard::kWheel}) {
          if (each == TimeGuard::kWheel && i % 5 != 0) continue;
          TimeNs time = clock.now + (each == source ? by * kMs : 0);
          const std::string reason = clock.guard.check(each, time);
          told += reason.rfind("clock was set", 0) == 0;
          if (!reason.empty()) continue;
          ++taken;
          EXPECT_NEAR(to_seconds(time - clock.now), 0.0, 0.03) << by;
          if (each == TimeGuard::kImu) {
            EXPECT_GT(time, newest);
            newest = time;
          }
        }
        ASSERT_FALSE(clock.guard.moved());
      }
      EXPECT_EQ(told, 1) << source << ' ' << by;
      EXPECT_GT(taken, 360) << source << ' ' << by;
    }
  }
}

// A busy driver: late stamps of the IMU show no clock that was set back.
TEST(TimeGuard, OneMessageInFiveLateIsNoClockSetBack) {
  Clock clock;
  clock.run(2);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0.0, 1.0), late_s(0.5, 2.0);
  for (int i = 0; i < 20000; ++i) {
    clock.now += 10 * kMs;
    const bool late = share(random) < 0.2;
    TimeNs imu = clock.now - (late ? from_seconds(late_s(random)) : 0);
    const TimeNs stamp = imu;
    const std::string reason = clock.guard.check(TimeGuard::kImu, imu);
    ASSERT_EQ(reason, late ? "later than time.reorder_window" : "") << i;
    ASSERT_EQ(imu, stamp);
  }
}

TEST(TimeGuard, ASensorThatComesLateForGoodWasNotSet) {
  Clock clock;
  clock.run(2);
  for (int i = 0; i < 400; ++i) {
    clock.now += 10 * kMs;
    TimeNs imu = clock.now, wheel = clock.now - 1000 * kMs;
    EXPECT_EQ(clock.guard.check(TimeGuard::kImu, imu), "");
    if (i < 100 || i % 5 != 0) continue;  // held back for a second
    EXPECT_EQ(clock.guard.check(TimeGuard::kWheel, wheel), "later than time.reorder_window");
  }
}

struct Step {
  TimeGuard::Source wheels;
  TimeNs by;
};
class TimeGuardOfAll : public testing::TestWithParam<Step> {};

// All clocks are set between two messages, several times. The time continues without a step back or
// a gap and, where they are set ahead, sensor_stamp() gives the clock's own stamps.
TEST_P(TimeGuardOfAll, ClockSetWithAllSensorsIsContinued) {
  const auto [wheels, by] = GetParam();
  Clock clock;
  clock.wheel_source = wheels;
  clock.run(2);
  TimeNs newest = clock.now, set = 0;
  const bool ahead = by > 0;
  for (int step = 1; step <= 3; ++step) {
    const TimeNs before = newest, was = clock.guard.sensor_stamp(before);
    EXPECT_TRUE(!ahead || was == clock.now + set);
    set += by;
    int taken = 0, reasons = 0;
    for (int i = 0; i < 400; ++i) {
      clock.now += 10 * kMs;
      const TimeNs stamp = clock.now + set;
      TimeNs imu = stamp, wheel = stamp + kMs;
      const std::string reason = clock.guard.check(TimeGuard::kImu, imu);
      reasons += reason.rfind(ahead ? "clock was set ahead with those of all sensors"
                                    : "clock was set back: its stamps are carried on",
                              0) == 0;
      const bool wheel_taken = i % 2 == 0 && clock.guard.check(wheels, wheel).empty();
      ASSERT_FALSE(clock.guard.moved());
      EXPECT_TRUE(!wheel_taken || !ahead || clock.guard.sensor_stamp(wheel) == stamp + kMs);
      if (!reason.empty()) continue;
      ++taken;
      EXPECT_NEAR(to_seconds(imu - clock.now), 0.0, 0.1);
      EXPECT_GT(imu, newest);
      EXPECT_TRUE(!ahead || clock.guard.sensor_stamp(imu) == stamp);
      newest = imu;
    }
    EXPECT_EQ(reasons, 1);
    EXPECT_GE(taken, ahead ? 390 : 340);
    EXPECT_EQ(clock.guard.sensor_stamp(before), was) << "what was, stays";
  }
}
INSTANTIATE_TEST_SUITE_P(OneOrTwo, TimeGuardOfAll,
                         testing::Values(Step{TimeGuard::kWheel, 3600'000 * kMs},
                                         Step{TimeGuard::kWheels, 3600'000 * kMs},
                                         Step{TimeGuard::kWheel, -3600'000 * kMs},
                                         Step{TimeGuard::kWheel, -1000 * kMs}));

// Packets from anywhere may come before the robot's own.
TEST(TimeGuard, StampsBeforeTheFirstImuMessageAreIgnored) {
  Clock clock;
  EXPECT_NE(check(clock.guard, TimeGuard::kGpr, kStart + 100'000'000 * kMs), "");
  clock.run(1);
  EXPECT_EQ(clock.taken_imu, 100);
  EXPECT_EQ(check(clock.guard, TimeGuard::kGpr, clock.now), "");
}

TEST(TimeGuard, LateStampWithinTheWindowIsUsedAndARepeatedOneIsNot) {
  Clock clock;
  clock.run(1);
  EXPECT_EQ(check(clock.guard, TimeGuard::kWheel, clock.now - 300 * kMs), "");
  EXPECT_EQ(check(clock.guard, TimeGuard::kWheel, clock.now - 400 * kMs),
            "later than time.reorder_window");
  EXPECT_EQ(check(clock.guard, TimeGuard::kImu, clock.now), "stamp repeated");
}

}  // namespace
}  // namespace gprodom
