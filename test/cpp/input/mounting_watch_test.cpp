// Robots whose IMU is turned otherwise than the configuration says, and robots whose IMU is not.
#include "input/mounting_watch.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace gprodom {
namespace {

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
MountingWatch watched(const Robot& robot, double seconds) {
  MountingWatch watch;
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  const auto shake = [&](double sigma) {
    return Vector3d(sigma * noise(random), sigma * noise(random), sigma * noise(random));
  };
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
          shake(robot.vibration);
      step.angular_velocity =
          robot.turned * Vector3d(0, 0, rate) + bias + shake(0.2 * robot.vibration);
      steps.push_back(step);
      way += speed * 0.01;
      heading += rate * 0.01;
    }
    watch.add(steps, robot.wheel ? std::optional(robot.wheel_sign * way) : std::nullopt, bias);
  }
  return watch;
}

std::string told(const Robot& robot, double seconds = 120.0) {
  return watched(robot, seconds).trouble();
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

// Angles at random, found within their own standard deviation. Turning the blocks with the axes is
// as good as having had the right axes all the time.
TEST(MountingWatch, FindsAnyYaw) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-180.0, 180.0);
  for (int i = 0; i < 20; ++i) {
    Robot robot;
    robot.vibration = 0.5;
    robot.turned = about(Vector3d::UnitZ(), any(random));
    MountingWatch watch = watched(robot, 60.0);
    const auto turn = watch.turn();
    ASSERT_TRUE(turn && turn->usable);
    const double off = Eigen::AngleAxisd(turn->R * robot.turned).angle();
    EXPECT_LT(off, 3 * turn->yaw_sigma);
    EXPECT_LT(off, 3 * kDegree);
    watch.turned(turn->R);
    EXPECT_LT(Eigen::AngleAxisd(watch.turn()->R).angle(), 1e-9);
    EXPECT_NEAR(watch.turn()->yaw_sigma, turn->yaw_sigma, 1e-9);
  }
}

TEST(MountingWatch, NoYawIsUsableWhereNoneShows) {
  Robot robot;
  robot.speed = 0.0;
  EXPECT_FALSE(watched(robot, 120.0).turn());
  robot = {};
  robot.wheel = false;
  EXPECT_FALSE(watched(robot, 120.0).turn());
  robot = {};
  robot.vibration = 30.0;
  const auto shaken = watched(robot, 20.0).turn();
  EXPECT_FALSE(shaken && shaken->usable);
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
