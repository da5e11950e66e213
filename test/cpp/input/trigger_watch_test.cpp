#include "input/trigger_watch.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gprodom {
namespace {

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
