#include "input/imu_mounting.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "input/mounting_watch.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 5e-3;
const Vector3d kArm(0.5, -0.3, 0.2), kGravity(0, 0, 9.81);

ImuConfig with_arm() {
  ImuConfig config;
  config.lever_arm = kArm;
  return config;
}

Vector3d rate(double t) { return {0.2 * std::sin(2 * t), 0.1, std::sin(3 * t)}; }

// How the body turns from t to t + h.
Eigen::Matrix3d turned(double t, double h) {
  constexpr int kParts = 20;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int i = 0; i < kParts; ++i) {
    const Vector3d phi = rate(t + (i + 0.5) * h / kParts) * h / kParts;
    R = R * Eigen::AngleAxisd(phi.norm(), phi.normalized()).toRotationMatrix();
  }
  return R;
}

// As an IMU at the end of the arm measures it: by numeric second derivative of its place.
ImuSample sample(double t) {
  constexpr double h = 1e-3;
  ImuSample imu;
  imu.time = from_seconds(100 + t);
  imu.acceleration = kGravity + (turned(t, h) * kArm - 2 * kArm + turned(t, -h) * kArm) / (h * h);
  imu.angular_velocity = rate(t);
  return imu;
}

// The filter is late, so some remains while the turn rate changes, which does not add up: the
// velocity is off by T alpha x r at most (0.04 m/s), after a minute as at first.
TEST(ImuMounting, TurningIsTakenOutOfTheAccelerationsOfAnArmsEnd) {
  ImuMounting mounting(with_arm());
  double worst = 0.0, worst_before = 0.0;
  Vector3d velocity = Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (double t = 0.0; t < 60.0; t += kStep_s) {
    const ImuSample imu = sample(t);
    const Vector3d error = mounting.in_body(imu).acceleration - kGravity;
    if (t < 0.5) continue;  // the filter begins
    worst = std::max(worst, error.norm());
    worst_before = std::max(worst_before, (imu.acceleration - kGravity).norm());
    R = R * turned(t - kStep_s, kStep_s);
    velocity += R * error * kStep_s;
    ASSERT_LT(velocity.norm(), 0.06) << t;
  }
  EXPECT_LT(worst, 0.1 * worst_before);
}

TEST(ImuMounting, LateAndMissingSamplesLeaveItFinite) {
  ImuMounting mounting(with_arm());
  for (const double t : {0.0, 0.01, 0.005, 0.01, 0.02, 5.0, 5.01}) {
    const ImuSample body = mounting.in_body(sample(t));
    EXPECT_TRUE(body.acceleration.allFinite()) << t;
    EXPECT_LT((body.acceleration - kGravity).norm(), 5.0) << t;
  }
}

TEST(ImuMounting, WithoutAnArmNothingIsChanged) {
  ImuMounting mounting{ImuConfig()};
  const ImuSample imu = sample(1.0);
  EXPECT_EQ(mounting.in_body(imu).acceleration, imu.acceleration);
  EXPECT_EQ(mounting.in_body(imu).angular_velocity, imu.angular_velocity);
}

// Robots whose IMU is turned otherwise than the configuration says, and robots whose IMU is not.
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

struct Robot {
  Matrix3d turned = Matrix3d::Identity();  // the IMU, beyond what the configuration says
  double slope = 0.0;                      // rad, of the ground
  double vibration = 0.05;                 // m/s^2 of a sample; rad/s a fifth of it
  double speed = 0.6;                      // m/s, about which it swings
  double wheel_sign = 1.0;
  bool bends = true;
  bool wheel = true;
};

Matrix3d about(const Vector3d& axis, double degrees) {
  return AngleAxisd(degrees * kDegree, axis.normalized()).toRotationMatrix();
}

// What is told after so many seconds; states every 0.2 s, IMU at 100 Hz.
std::string told(const Robot& robot, double seconds = 120.0) {
  MountingWatch watch;
  Noise noise(7);
  const Vector3d bias(0.004, -0.003, 0.002);
  double way = 0.0, heading = 0.0;
  for (int state = 0; state < static_cast<int>(seconds * 5); ++state) {
    std::vector<MotionStep> steps;
    for (int i = 0; i < 20; ++i) {
      const double t = 0.2 * state + 0.01 * i;
      const double speed = robot.speed * (1 + 0.8 * std::sin(0.7 * t));
      const double faster = robot.speed * 0.56 * std::cos(0.7 * t);
      const double rate = robot.bends ? 0.5 * std::sin(0.31 * t) : 0.0;
      const Matrix3d level = about(Vector3d::UnitZ(), -heading / kDegree) *
                             about(Vector3d::UnitY(), robot.slope / kDegree);
      MotionStep step;
      step.dt = 0.01;
      step.acceleration =
          robot.turned * (Vector3d(faster, speed * rate, 0) + level * Vector3d(0, 0, 9.8)) +
          noise.vector(robot.vibration);
      step.angular_velocity =
          robot.turned * Vector3d(0, 0, rate) + bias + noise.vector(0.2 * robot.vibration);
      steps.push_back(step);
      way += speed * 0.01;
      heading += rate * 0.01;
    }
    watch.add(steps, robot.wheel ? std::optional(robot.wheel_sign * way) : std::nullopt, bias);
  }
  return watch.trouble();
}

testing::AssertionResult says(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos && text.find("calibrate mount") != std::string::npos)
    return testing::AssertionSuccess();
  return testing::AssertionFailure() << '"' << text << '"';
}

TEST(MountingWatch, ARightMountingIsNotTold) {
  EXPECT_EQ(told({}), "");
  Robot robot;
  robot.turned = about({1, 1, 1}, 5);
  EXPECT_EQ(told(robot), "") << "vague, as by eye";
  robot = {};
  robot.slope = 20 * kDegree;
  EXPECT_EQ(told(robot), "") << "to and fro on a slope";
  robot.bends = false;
  EXPECT_EQ(told(robot), "") << "straight up a slope";
  robot = {};
  robot.vibration = 3.0;
  EXPECT_EQ(told(robot), "") << "shaken";
  robot = {};
  robot.speed = 0.0;
  EXPECT_EQ(told(robot), "") << "standing";
}

TEST(MountingWatch, GravityThatIsNoSlopeIsToldAtOnce) {
  for (const double degrees : {90.0, 180.0, -90.0}) {
    Robot robot;
    robot.turned = about(Vector3d::UnitX(), degrees);
    robot.speed = 0.0;
    robot.wheel = false;
    const std::string off = std::to_string(static_cast<int>(std::abs(degrees)));
    EXPECT_TRUE(says(told(robot, 8.0), "gravity is " + off + " degrees off")) << degrees;
  }
}

TEST(MountingWatch, TheAxisOfTurnsTellsALeaningImuFromASlope) {
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0.6, 0.8, 0)}) {
    Robot robot;
    robot.turned = about(axis, 20);
    EXPECT_TRUE(says(told(robot), "axis of turns are 20 degrees off"));
    robot.slope = 10 * kDegree;
    EXPECT_TRUE(says(told(robot), "axis of turns"));
  }
}

TEST(MountingWatch, AccelerationsTellAnImuThatLooksElsewhere) {
  for (const double degrees : {20.0, -20.0, 90.0, 180.0}) {
    Robot robot;
    robot.turned = about(Vector3d::UnitZ(), degrees);
    EXPECT_TRUE(says(told(robot), "about the up axis")) << degrees;
    robot.bends = false;
    EXPECT_TRUE(says(told(robot), "about the up axis")) << degrees << ", straight ahead";
    EXPECT_EQ(told(robot, 20.0), "") << "too early to say";
    robot.wheel = false;
    EXPECT_EQ(told(robot), "") << "nothing to compare with";
  }
  Robot robot;
  robot.wheel_sign = -1.0;
  EXPECT_TRUE(says(told(robot), "wheel counts backwards"));
}

TEST(MountingWatch, AGapOfTheImuIsNoAcceleration) {
  MountingWatch watch;
  MotionStep step;
  step.dt = 0.2;
  step.acceleration = {0, 9.8, 0};
  step.bridged = true;
  for (int i = 0; i < 200; ++i) watch.add({step}, 0.0, Vector3d::Zero());
  EXPECT_EQ(watch.trouble(), "");
}

}  // namespace
}  // namespace gprodom
