// Faulty sensors must be detected, and a coarse sensor must not be reported as broken.
#include "input/sensor_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

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
      sample.acceleration[i] = rounded(0.15 * noise_(random_));
      sample.angular_velocity[i] = rounded(0.05 * noise_(random_));
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
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_;
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

TEST(ImuWatch, ConstantValuesAreNotUsed) {
  DrivingImu imu;
  ImuWatch watch;
  for (int i = 0; i < 5000; ++i) watch.check(imu.next());
  ImuSample sample = imu.next();
  int dropped = 0;
  for (int i = 0; i < 100; ++i) {
    sample.time += 5'000'000;
    dropped += !watch.check(sample).empty();
  }
  EXPECT_GE(dropped, 90);
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
  GprTrace trace;
  trace.samples.assign(201, 7.0f);
  TraceWatch watch;
  for (double wheel_m = 50.0; wheel_m < 55.0; wheel_m += 0.3)
    EXPECT_EQ(watch.check(trace, wheel_m).empty(), wheel_m < 50.0 + TraceWatch::kGoesFar)
        << wheel_m;
  trace.samples[100] += 1;
  EXPECT_EQ(watch.check(trace, 55.0), "");
}

// Of one without noise, as a simulated one: equal traces are no fault while the robot stands.
TEST(TraceWatch, TheSameTraceAtAStandstillIsNotStuck) {
  GprTrace trace;
  trace.samples.assign(201, 7.0f);
  TraceWatch watch;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(watch.check(trace, 50.0 + 0.001 * (i % 3)), "");
}

}  // namespace
}  // namespace gprodom
