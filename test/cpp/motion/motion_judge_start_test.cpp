// The first state: from a standstill, from a short stop, or on the move.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "motion/judged_robot.h"
#include "motion/motion_judge.h"
#include "support/noise.h"

namespace gprodom {
namespace {

// A robot before its first state, with IMU and wheel at 100 Hz.
class Starting {
 public:
  explicit Starting(const Config& config = {}) : judge(config) {}

  // The next samples.
  void go_on(double wheel_mps, double push = 0.0) {
    ImuSample imu{from_seconds(seconds()), {push, 0, 9.80665 + accel_bias}, kBias};
    imu.acceleration += noise_.vector(0.01);
    judge.add(imu);
    judge.add(WheelSample{imu.time, wheel_m_ += 0.01 * wheel_mps});
    ++i_;
  }
  double seconds() const { return 0.01 * i_; }

  // The first state if there is one, ten times a second.
  std::optional<InitialState> asked() {
    return i_ % 10 == 0 ? judge.initialize().initial : std::nullopt;
  }

  MotionJudge judge;
  double accel_bias = 0.0;  // m/s^2, along gravity

 private:
  Noise noise_{1};
  double wheel_m_ = 0.0;
  int i_ = 0;
};

TEST(MotionJudgeStart, TheFirstStateComesFromAStandstillOrFromTheMove) {
  struct Case {
    double wheel_speed;
    bool waits, starts;
  };
  for (const auto& [wheel_speed, waits, starts] : {Case{0.0, false, true}, Case{0.5, false, true},
                                                   Case{0.0, true, true}, Case{0.5, true, false}}) {
    Config config;
    config.initializer.wait_for_standstill = waits;
    Starting robot(config);
    while (robot.seconds() < 7.995) robot.go_on(wheel_speed);
    const Initialization start = robot.judge.initialize();
    ASSERT_EQ(start.initial.has_value(), starts) << start.refusal;
    if (!starts) {
      EXPECT_NE(start.refusal.find("hold the robot still"), std::string::npos) << start.refusal;
      continue;
    }
    EXPECT_EQ(start.initial->on_the_move, wheel_speed > 0.0);
    EXPECT_EQ(start.initial->state.time, from_seconds(7.99));
    // On the move nothing shows the bias: it is taken for zero.
    EXPECT_LT((start.initial->state.gyro_bias - (wheel_speed > 0 ? 0 : 1) * kBias).norm(), 1e-9);
  }
}

// A robot that brakes, stands for less than initializer.duration and drives on: the stop shows tilt
// and bias, the braking before it must not be taken for a part of it.
TEST(MotionJudgeStart, StartsFromAShortStopWithoutTheBrakingBeforeIt) {
  Starting robot;
  std::optional<InitialState> initial;
  while (robot.seconds() < 8 && !initial) {
    const double t = robot.seconds(), brakes_at = 1.5, stands_at = 2.5, drives_at = 4.0;
    const bool brakes = t >= brakes_at && t < stands_at;
    const double speed = t < brakes_at || t >= drives_at ? 0.5 : brakes ? 0.5 * (stands_at - t) : 0;
    robot.go_on(speed, brakes ? -0.5 : 0);
    if (t > brakes_at + 0.5) initial = robot.asked();
    if (initial) {
      EXPECT_TRUE(t > stands_at && t < drives_at) << t;
    }
  }
  ASSERT_TRUE(initial);
  EXPECT_FALSE(initial->on_the_move);
  EXPECT_LT((initial->state.gyro_bias - kBias).norm(), 1e-9);
  const double sine_of_pitch = (initial->state.R_odom_body() * Eigen::Vector3d::UnitX()).z();
  EXPECT_NEAR(sine_of_pitch, 0.0, 1e-3);  // half a second of the braking would tilt it by 0.01
}

// One that sets off before it has stood for initializer.duration starts on the move, with the
// biases of the standstill; one that stood for too short a time, with none.
TEST(MotionJudgeStart, AShortStandstillBeforeTheDriveTellsTheBiases) {
  for (const double sets_off_at : {0.6, 1.5}) {
    Starting robot;
    robot.accel_bias = 0.3;
    while (robot.seconds() < 7.995) {
      const double driven = robot.seconds() - sets_off_at;
      const double speed = std::clamp(0.5 * driven, 0.0, 0.5);
      robot.go_on(speed, speed > 0 && speed < 0.5 ? 0.5 : 0);
    }
    const auto initial = robot.judge.initialize().initial;
    ASSERT_TRUE(initial) << sets_off_at;
    EXPECT_TRUE(initial->on_the_move);
    const bool told = sets_off_at > 1.0;
    EXPECT_LT((initial->state.gyro_bias - (told ? 1 : 0) * kBias).norm(), 1e-9);
    const double sigma = 1 / initial->prior.A.col(row::kBg).norm();
    EXPECT_EQ(sigma < 0.5 * kUsualGyroBias, told) << sigma;
    EXPECT_NEAR(initial->state.accel_bias.z(), told ? robot.accel_bias : 0.0, 0.01);
  }
}

// Seconds until a robot at 0.5 m/s starts on the move, whose wheel slips until `slips_until`, and
// again and again after that if it `jerks`.
double starts_after(double slips_until, bool jerks) {
  Starting robot;
  while (robot.seconds() < 20) {
    const double t = robot.seconds();
    robot.go_on(t < slips_until || (jerks && std::fmod(t, 3.5) < 0.8) ? 0.75 : 0.5);
    if (t > 2 && robot.asked()) return t;
  }
  return 20.0;
}

TEST(MotionJudgeStart, AStartOnTheMoveWaitsForAWheelThatDoesNotSlip) {
  EXPECT_LT(starts_after(0.0, false), 4.5);
  EXPECT_GT(starts_after(2.5, false), 6.0);  // the slip's end is out of sight
  EXPECT_LT(starts_after(2.5, false), 7.0);
  EXPECT_GT(starts_after(0.0, true), 8.0);
  EXPECT_LT(starts_after(0.0, true), 10.0);  // it starts as well as it can
}

}  // namespace
}  // namespace gprodom
