// A late wheel: which of the IMU's data belong to its distances.
#include "motion/late_wheel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "motion/grip_filter.h"

namespace gprodom {
namespace {

constexpr double kDelay_s = 0.43, kInterval_s = 0.2, kGravity = 9.80665;

// Stands for 4 s, sets off, and stands again from 30 to 34 s and from 60 s on.
double speed(double t) {
  const double on = std::min(t - 4, std::max(30 - t, t - 34)), off = 60 - t;
  return std::clamp(std::min(on, off), 0.0, 1.0) * (1.0 + 0.4 * std::sin(0.9 * t));
}

bool stands(double from, double to) { return speed(from) == 0.0 && speed(to) == 0.0; }

// A robot that drives along a straight line with a wheel that is late by kDelay_s, and the filter
// that judges its grip. l(t): ln(true distance / distance by the wheel).
class Drive {
 public:
  // told_s: the delay that is said to be learnt.
  explicit Drive(double told_s) : filter(Config()), told_s_(told_s) {
    start_.covariance.diagonal().setConstant(1e-8);
  }

  GripFilter filter;

  template <typename Slip>
  void to(double end, Slip l) {
    while (now_ < end) {
      for (const double until = now_ + kInterval_s + kStep_s; sampled_ < until; sampled_ += kStep_s)
        sample(l);
      interval();
    }
  }

 private:
  static constexpr double kStep_s = 0.01;

  template <typename Slip>
  void sample(Slip l) {
    const double t = sampled_, h = 1e-3, rolled = t - kDelay_s;
    const double acceleration = (speed(t + h) - speed(t - h)) / (2 * h);
    const double noise = kNoise.accel_density / std::sqrt(kStep_s);
    imu_.insert({from_seconds(t),
                 {acceleration + noise * normal_(engine_), 0, kGravity},
                 Eigen::Vector3d::Zero()});
    wheel_.insert({from_seconds(t), wheel_m_});
    wheel_m_ += speed(rolled) * std::exp(-l(rolled)) * kStep_s;
  }

  void interval() {
    const TimeNs from = from_seconds(now_), to = from_seconds(now_ + kInterval_s);
    StateInput input;
    input.time = to;
    input.noise = kNoise;
    input.wheel_late = told_s_ > 0;
    input.wheel_delay_s = told_s_;
    input.steps = imu_.steps(from, to);
    input.has_wheel = set_wheel_distances(input.steps, wheel_, from, false);
    input.standing = stands(now_, now_ + kInterval_s);
    start_.state.v_odom.x() = speed(now_);
    late_.follow(input);
    filter.advance(late_.earlier(input, from, imu_, wheel_), start_,
                   {0.0, 0.0, kNoise.accel_density});
    now_ += kInterval_s;
  }

  static constexpr ImuNoise kNoise{3e-4, 0.01};
  double told_s_;
  LateWheel late_;
  ImuHistory imu_;
  WheelHistory wheel_{10.0};
  StateResult start_;
  double now_ = 1.0, sampled_ = 0.0, wheel_m_ = 0.0;
  std::mt19937 engine_{3};
  std::normal_distribution<double> normal_;
};

double grips(double) { return 0.0; }
double slips(double t) { return -0.25 * std::clamp((t - 40) / 3, 0.0, 1.0); }

// What the wheel is late by looks like an error of the accelerations, which hides slip.
TEST(LateWheel, ThatGripsLeavesTheAccelerationsRight) {
  Drive told(kDelay_s), not_told(0.0);
  told.to(60, grips);
  not_told.to(60, grips);
  EXPECT_LT(told.filter.slips(), 0.1);
  EXPECT_LT(2 * told.filter.error_density(), not_told.filter.error_density());
}

TEST(LateWheel, ThatSlipsIsSeen) {
  Drive drive(kDelay_s);
  drive.to(45, slips);
  EXPECT_GT(drive.filter.slips(), 0.9);
  EXPECT_TRUE(drive.filter.wheel_is_fast());
}

TEST(LateWheel, TakesStandstillAndStepsOfTheTimeWhenItRolled) {
  ImuHistory imu;
  WheelHistory wheel(10.0);
  for (TimeNs i = 0; i <= 300; ++i) {
    const TimeNs time = i * 10'000'000;
    imu.insert({time, {0.01 * static_cast<double>(i), 0, kGravity}, Eigen::Vector3d::Zero()});
    wheel.insert({time, 0.001 * static_cast<double>(i * i)});
  }
  LateWheel late;
  int changes = 0;
  for (int k = 5; k < 14; ++k) {
    const TimeNs from = k * 200'000'000LL, to = from + 200'000'000;
    StateInput input;
    input.time = to;
    input.has_wheel = true;
    input.standing = k < 8;
    input.wheel_late = true;
    input.wheel_delay_s = k < 8 ? 0.4 : 0.7;
    input.steps = imu.steps(from, to);
    changes += late.follow(input);
    EXPECT_EQ(late.waits(), k < 6);  // it is found late, and is in use from the next standstill on
    if (late.waits()) continue;
    const StateInput earlier = late.earlier(input, from, imu, wheel);
    EXPECT_EQ(earlier.time, to);
    EXPECT_EQ(earlier.standing, k < 10);  // two intervals later
    double seconds = 0.0, wheel_m = 0.0, gained = 0.0;
    for (const MotionStep& step : earlier.steps) {
      seconds += step.dt;
      wheel_m += step.wheel_m;
      gained += step.acceleration.x() * step.dt;
    }
    const double begin = to_seconds(from) - 0.4, end = begin + 0.2;
    EXPECT_NEAR(seconds, 0.2, 1e-9);
    EXPECT_NEAR(gained, 0.5 * (end * end - begin * begin), 1e-6);
    EXPECT_NEAR(wheel_m, *wheel.distance(to) - *wheel.distance(from), 1e-9);
  }
  EXPECT_EQ(changes, 2);
}

}  // namespace
}  // namespace gprodom
