// Faulty sensors must be detected, and a coarse sensor must not be reported as broken.
#include "input/sensor_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "gpr/synthetic_ground.h"
#include "input/clock_watch.h"
#include "input/trace_format_watch.h"
#include "input/trigger_watch.h"
#include "support/noise.h"

namespace gprodom {
namespace {

// Acceleration and rates of a robot that drives, at 200 Hz.
class DrivingImu {
 public:
  explicit DrivingImu(double step = 0.0) : step_(step) {}

  ImuSample next() {
    ImuSample sample;
    sample.time = time_ += 5'000'000;
    for (int i = 0; i < 3; ++i) {
      sample.acceleration[i] = rounded(0.15 * noise_());
      sample.angular_velocity[i] = rounded(0.05 * noise_());
    }
    sample.acceleration.z() += 9.8;
    return sample;
  }

 private:
  double rounded(double value) const {
    return step_ > 0 ? std::round(value / step_) * step_ : value;
  }

  double step_;
  TimeNs time_ = 0;
  Noise noise_{1};
};

TEST(ImuWatch, CoarseValuesAreNeitherStuckNorCutOff) {
  for (const double step : {0.0, 0.002, 0.01, 0.05, 0.2}) {
    DrivingImu imu(step);
    ImuWatch watch;
    for (int i = 0; i < 20'000; ++i) {
      ASSERT_EQ(watch.check(imu.next()), "") << step;
      ASSERT_EQ(watch.quality(), "") << step;
    }
  }
}

TEST(ImuWatch, SaturationIsReportedAndAConstantAxisIsNotUsed) {
  DrivingImu imu;
  ImuWatch watch;
  for (int i = 0; i < 5000; ++i) watch.check(imu.next());
  int told = 0, dropped = 0;
  for (int i = 0; i < 1000; ++i) {
    ImuSample sample = imu.next();
    sample.acceleration.x() = std::clamp(sample.acceleration.x(), -0.2, 0.2);
    dropped += !watch.check(sample).empty();
    told += !watch.quality().empty();
  }
  EXPECT_GE(told, 4);
  EXPECT_EQ(dropped, 0);
  for (int i = 0; i < 100; ++i) {
    ImuSample sample = imu.next();
    sample.angular_velocity.z() = 0.2;
    dropped += !watch.check(sample).empty();
  }
  EXPECT_GE(dropped, 90);
  EXPECT_EQ(watch.check(imu.next()), "");
}

TEST(GapWatch, MissingMessagesAreReportedAndJitterIsNot) {
  GapWatch watch;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.002, 0.002);
  double t = 1.0;
  for (int i = 0; i < 1000; ++i)
    ASSERT_FALSE(watch.gap_before(from_seconds((t += 0.02) + jitter(random))));
  EXPECT_TRUE(watch.gap_before(from_seconds(t += 0.06)));
  EXPECT_FALSE(watch.gap_before(from_seconds(t += 0.02)));
}

// A radar that hangs before anything is known of its noise; the wheel counts on.
TEST(TraceWatch, TheSameTraceAllAlongIsStuckOnceTheRobotHasDriven) {
  GprTrace trace = gpr::flat_trace(0);
  TraceWatch watch;
  for (double wheel_m = 50.0; wheel_m < 55.0; wheel_m += 0.3)
    EXPECT_EQ(watch.check(trace, wheel_m).empty(), wheel_m < 50.0 + TraceWatch::kGoesFar)
        << wheel_m;
  trace.samples[100] += 1;
  EXPECT_EQ(watch.check(trace, 55.0), "");
}

// Of one without noise, as a simulated one: equal traces are no fault while the robot stands.
TEST(TraceWatch, TheSameTraceAtAStandstillIsNotStuck) {
  GprTrace trace = gpr::flat_trace(0);
  TraceWatch watch;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(watch.check(trace, 50.0 + 0.001 * (i % 3)), "");
}

// Clocks that drift apart must be reported; delays that scatter or step must not be.
constexpr TimeNs kStart = 1'700'000'000'000'000'000;

// Times told over a run, of a sensor at 20 Hz beside an IMU at 200 Hz. delay_s(t): from the moment
// of a measurement to its arrival.
int times_told(double seconds, double ppm, const std::function<double(double)>& delay_s) {
  ClockWatch watch;
  int told = 0;
  for (double t = 0; t < seconds; t += 0.05) {
    const double arrival = t + delay_s(t);
    const TimeNs imu_now = kStart + from_seconds(0.005 * std::floor(arrival / 0.005 + 0.4));
    told += watch.drifts(kStart + from_seconds(t * (1 + 1e-6 * ppm)), imu_now);
  }
  return told;
}

std::function<double(double)> scattered(double most_s) {
  return [most_s, random = std::mt19937(1)](double) mutable {
    return std::uniform_real_distribution<double>(0, most_s)(random);
  };
}

TEST(ClockWatch, DriftIsReportedWithinTwoMinutesAndWhileItLasts) {
  for (const double ppm : {-300.0, -100.0, 100.0}) {
    EXPECT_GT(times_told(120, ppm, scattered(0.003)), 0) << ppm;
    EXPECT_GT(times_told(3600, ppm, scattered(0.003)), 300) << ppm;
    EXPECT_GT(times_told(3600, ppm, scattered(0.1)), 0) << ppm;
  }
}

TEST(ClockWatch, GoodClocksWithDelaysAreNotReported) {
  for (const double ppm : {-20.0, 0.0, 20.0})
    for (const double most_s : {0.0, 0.003, 0.05, 0.2})
      EXPECT_EQ(times_told(3600, ppm, scattered(most_s)), 0) << ppm << " ppm, " << most_s << " s";
  EXPECT_EQ(times_told(600, 0, [](double t) { return t < 300 ? 0.0 : 0.05; }), 0);
  EXPECT_EQ(times_told(600, 0, [](double t) { return t < 300 ? 0.05 : 0.001; }), 0);
}

TEST(ClockWatch, StampsThatRestartAreJudgedAnew) {
  ClockWatch watch;
  int told = 0;
  TimeNs now = kStart;
  for (int run = 0; run < 20; ++run) {
    now += run % 2 ? 3600'000'000'000 : -1800'000'000'000;
    for (int i = 0; i < 40 * 20; ++i) {
      now += 50'000'000;
      told += watch.drifts(now - run * 5'000'000, now);
    }
  }
  EXPECT_EQ(told, 0);
}

GprTrace trace(std::size_t samples, double interval_s) {
  return gpr::flat_trace(0, samples, interval_s);
}

TEST(TraceFormatWatch, SingleOddTraceIsDroppedAndANewSettingIsFollowed) {
  TraceFormatWatch format;
  EXPECT_EQ(format.check(trace(201, 2e-10)), "");
  for (int i = 0; i < 20; ++i) {
    EXPECT_NE(format.check(trace(181, 2e-10)), "");
    EXPECT_NE(format.check(trace(201, 3e-10)), "");
    EXPECT_EQ(format.check(trace(201, 2e-10)), "");
  }
  int dropped = 0;
  while (!format.check(trace(181, 2e-10)).empty()) ++dropped;
  EXPECT_EQ(dropped, 4);
  EXPECT_NE(format.check(trace(201, 2e-10)), "");
}

// The first trace may be the damaged one: it must not say which ground is stored.
TEST(TraceFormatWatch, SettingCountsOnceSeveralTracesAgree) {
  TraceFormatWatch format;
  format.check(trace(181, 2e-10));
  EXPECT_FALSE(format.agreed());
  for (int i = 0; i < 4; ++i) {
    format.check(trace(201, 2e-10));
    EXPECT_FALSE(format.agreed());
  }
  EXPECT_EQ(format.check(trace(201, 2e-10)), "");
  ASSERT_TRUE(format.agreed());
  EXPECT_EQ(format.agreed()->samples, 201U);
  format.check(trace(181, 2e-10));
  EXPECT_EQ(format.agreed()->samples, 201U);
}

TEST(TraceFormatWatch, SettingIsKnownThoughEveryOtherTraceIsDamaged) {
  TraceFormatWatch format;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_FALSE(format.agreed());
    format.check(trace(201, 2e-10));
    format.check(trace(100 + i, 2e-10));
  }
  EXPECT_EQ(format.agreed()->samples, 201U);
}

constexpr TimeNs kStep = 10'000'000;  // 100 Hz of the wheel

// A robot whose radar has a trace every `period`, or every `spacing_m`.
class Robot {
 public:
  TimeNs period = 0;
  double spacing_m = 0.0;
  TriggerWatch watch{Trigger::kAuto};

  void drive(double seconds, double speed) {
    for (int i = 0; i < static_cast<int>(std::lround(100 * seconds)); ++i) {
      now_ += kStep;
      at_m_ += speed * to_seconds(kStep);
      if (period > 0 && now_ % period == 0) watch.add_trace(now_);
      if (spacing_m > 0 && std::abs(at_m_ - traced_at_m_) >= spacing_m) {
        traced_at_m_ = at_m_;
        watch.add_trace(now_ - kStep / 2);  // before the wheel tells
      }
      watch.add_wheel(now_, at_m_);
    }
  }

 private:
  TimeNs now_ = 1'700'000'000'000'000'000;
  double at_m_ = 5.0, traced_at_m_ = 5.0;
};

TEST(TriggerWatch, TracesAtAStandstillComeByTime) {
  Robot robot;
  robot.period = 50'000'000;
  robot.drive(0.4, 0.0);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kAuto);
  robot.drive(2.0, 0.0);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kTime);
  for (int i = 0; i < 20; ++i) {
    robot.drive(3.0, 0.5);
    robot.drive(4.0, 0.0);
    EXPECT_EQ(robot.watch.trigger(), Trigger::kTime);
  }
}

TEST(TriggerWatch, NoneAtTheFirstStandstillAndSomeAtOnceAfterItComeByDistance) {
  for (const double spacing : {0.01, 0.02, 0.05, 0.1}) {
    Robot robot;
    robot.spacing_m = spacing;
    robot.drive(5.0, 0.0);
    EXPECT_EQ(robot.watch.trigger(), Trigger::kAuto);
    robot.drive(1.0, 0.3);
    EXPECT_EQ(robot.watch.trigger(), Trigger::kDistance) << spacing;
    robot.drive(600.0, 0.0);
    EXPECT_FALSE(robot.watch.is_due()) << "none is missing at a stop of ten minutes";
    robot.drive(1.0, -0.3);
    EXPECT_EQ(robot.watch.trigger(), Trigger::kDistance);
  }
}

TEST(TriggerWatch, StartedOnTheMoveTheFirstStopDecides) {
  Robot robot;
  robot.spacing_m = 0.03;
  robot.drive(20.0, 0.5);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kAuto);
  robot.drive(2.0, 0.0);
  robot.drive(5.0, 0.5);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kAuto) << "too short a stop";
  robot.drive(5.0, 0.0);
  robot.drive(0.5, 0.5);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kDistance);
}

// It has failed before the stop, and comes back long after it.
TEST(TriggerWatch, ARadarThatFailsIsNoneByDistance) {
  Robot robot;
  robot.drive(5.0, 0.0);
  robot.drive(5.0, 0.5);
  EXPECT_TRUE(robot.watch.is_due());
  robot.period = 50'000'000;
  robot.drive(5.0, 0.5);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kAuto);
  EXPECT_FALSE(robot.watch.is_due());
}

TEST(TriggerWatch, AWrongFindingIsMendedAtTheNextStandstill) {
  Robot robot;
  robot.drive(5.0, 0.0);
  robot.period = 50'000'000;  // it was switched on just when the robot drove off
  robot.drive(5.0, 0.5);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kDistance);
  robot.drive(2.0, 0.0);
  EXPECT_EQ(robot.watch.trigger(), Trigger::kTime);
}

TEST(TriggerWatch, WhatTheConfigurationTellsIsNotDoubted) {
  TriggerWatch by_time(Trigger::kTime), by_distance(Trigger::kDistance);
  for (TimeNs t = kStep; t < 1000 * kStep; t += kStep) {
    by_time.add_wheel(t, 0.0);
    by_distance.add_wheel(t, 0.0);
    by_distance.add_trace(t);
  }
  EXPECT_EQ(by_time.trigger(), Trigger::kTime);
  EXPECT_EQ(by_distance.trigger(), Trigger::kDistance);
}

TEST(TriggerWatch, ACounterThatWasSetBackIsNoWay) {
  TriggerWatch watch(Trigger::kDistance);
  watch.add_wheel(1, 1000.0);
  watch.add_wheel(2, 0.0);
  EXPECT_FALSE(watch.is_due());
  for (int i = 1; i <= 60; ++i) watch.add_wheel(2 + i, 0.01 * i);
  EXPECT_TRUE(watch.is_due());
}

}  // namespace
}  // namespace gprodom
