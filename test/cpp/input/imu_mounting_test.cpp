#include "input/imu_mounting.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "input/mounting_search.h"
#include "input/mounting_watch.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
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
Matrix3d turned(double t, double h) {
  constexpr int kParts = 20;
  Matrix3d R = Matrix3d::Identity();
  for (int i = 0; i < kParts; ++i) {
    const Vector3d phi = rate(t + (i + 0.5) * h / kParts) * h / kParts;
    R = R * AngleAxisd(phi.norm(), phi.normalized()).toRotationMatrix();
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
  Matrix3d R = Matrix3d::Identity();
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

// Robots whose IMU is turned otherwise than the configuration says, and robots whose IMU is not.
constexpr double kDegree = M_PI / 180;

struct Turned {
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
std::string told(const Turned& robot, double seconds = 120.0) {
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
      const Vector3d force = Vector3d(faster, speed * rate, 0) + level * Vector3d(0, 0, 9.8);
      const Vector3d of_force = noise.vector(robot.vibration);
      const Vector3d of_rate = bias + noise.vector(0.2 * robot.vibration);
      steps.push_back({0.01,
                       robot.turned * force + of_force,
                       robot.turned * Vector3d(0, 0, rate) + of_rate,
                       0.0,
                       false,
                       false,
                       {}});
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
  Turned robot;
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
    Turned robot;
    robot.turned = about(Vector3d::UnitX(), degrees);
    robot.speed = 0.0;
    robot.wheel = false;
    const std::string off = std::to_string(static_cast<int>(std::abs(degrees)));
    EXPECT_TRUE(says(told(robot, 8.0), "gravity is " + off + " degrees off")) << degrees;
  }
}

TEST(MountingWatch, TheAxisOfTurnsTellsALeaningImuFromASlope) {
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0.6, 0.8, 0)}) {
    Turned robot;
    robot.turned = about(axis, 20);
    EXPECT_TRUE(says(told(robot), "axis of turns are 20 degrees off"));
    robot.slope = 10 * kDegree;
    EXPECT_TRUE(says(told(robot), "axis of turns"));
  }
}

TEST(MountingWatch, AccelerationsTellAnImuThatLooksElsewhere) {
  for (const double degrees : {20.0, -20.0, 90.0, 180.0}) {
    Turned robot;
    robot.turned = about(Vector3d::UnitZ(), degrees);
    EXPECT_TRUE(says(told(robot), "about the up axis")) << degrees;
    robot.bends = false;
    EXPECT_TRUE(says(told(robot), "about the up axis")) << degrees << ", straight ahead";
    EXPECT_EQ(told(robot, 20.0), "") << "too early to say";
    robot.wheel = false;
    EXPECT_EQ(told(robot), "") << "nothing to compare with";
  }
  Turned robot;
  robot.wheel_sign = -1.0;
  EXPECT_TRUE(says(told(robot), "wheel counts backwards"));
}

TEST(MountingWatch, AGapOfTheImuIsNoAcceleration) {
  MountingWatch watch;
  const MotionStep step{0.2, {0, 9.8, 0}, {0, 0, 0}, 0.0, true, false, {}};
  for (int i = 0; i < 200; ++i) watch.add({step}, 0.0, Vector3d::Zero());
  EXPECT_EQ(watch.trouble(), "");
}

// Robots whose IMU is mounted in an unknown way.

Matrix3d about_up(double yaw) { return AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix(); }

double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

// A robot on bumpy ground: its speed changes every two seconds, as its turn rate; its pitch and
// roll wander by `tilt` (rad) within seconds.
class Robot {
 public:
  Robot(unsigned seed, double tilt, bool drives = true)
      : normal_(seed), tilt_(tilt), drives_(drives) {}

  // 0.2 s at 50 Hz, in axes turned by R_axes_body.
  void move(MountingSearch& search, const Matrix3d& R_axes_body) {
    move_with(search, R_axes_body, R_axes_body);
  }

  // of_force, of_rate: what the accelerometer and the gyro have for axes.
  void move_with(MountingSearch& search, const Matrix3d& of_force, const Matrix3d& of_rate) {
    if (drives_ && state_ % 10 == 0) {
      wanted_ = 0.5 + 0.4 * normal_();
      rate_ = 0.3 * normal_();
    }
    ++state_;
    std::vector<MotionStep> steps;
    for (int i = 0; i < 10; ++i) {
      const double faster = wanted_ - speed_;
      speed_ += 0.02 * faster;
      way_ += 0.02 * speed_;
      for (double* lean : {&pitch_, &roll_}) *lean += -0.02 * *lean + 0.2 * tilt_ * normal_();
      const Vector3d force(faster - 9.8 * pitch_, speed_ * rate_ + 9.8 * roll_, 9.8);
      steps.push_back({0.02,
                       of_force * (force + normal_.vector(0.05)),
                       of_rate * Vector3d(0, 0, rate_),
                       0.0,
                       false,
                       false,
                       {}});
    }
    search.add(steps, way_, Vector3d::Zero());
  }

  // Drives for so many states. The axes from R on, as the search turns them.
  Matrix3d drive(MountingSearch& search, Matrix3d R, int states) {
    for (int state = 0; state < states; ++state) {
      move(search, R);
      if (const auto turn = search.take_turn()) R = *turn * R;
    }
    return R;
  }

 private:
  Noise normal_;
  double tilt_, wanted_ = 0.4, speed_ = 0.4, rate_ = 0.0, way_ = 0.0, pitch_ = 0.0, roll_ = 0.0;
  bool drives_;
  int state_ = 0;
};

// 200 mountings, on even ground and on ground that tilts the robot by degrees: the errors of all
// turns are as large as their standard deviations say.
TEST(MountingSearch, TheYawIsFoundWithItsStandardDeviation) {
  for (const double tilt : {0.2 * kDegree, 3 * kDegree}) {
    double squares = 0.0, most = 0.0, last = 0.0;
    int turns = 0;
    for (unsigned seed = 1; seed <= 200; ++seed) {
      Robot robot(seed, tilt);
      MountingSearch search;
      Matrix3d R = about_up(0.1 * seed);
      const int states = tilt < kDegree ? 150 : 1500;
      for (int state = 0; state < states; ++state) {
        robot.move(search, R);
        const auto turn = search.take_turn();
        if (!turn) continue;
        R = *turn * R;
        last = wrapped(std::atan2(R(1, 0), R(0, 0)));
        squares += std::pow(last / search.yaw_sigma(), 2);
        most = std::max(most, std::abs(last) / search.yaw_sigma());
        ++turns;
      }
      EXPECT_TRUE(search.known()) << "tilt " << tilt << ", seed " << seed;
    }
    EXPECT_GE(turns, 400);
    // On even ground the noise is less than its prior.
    EXPECT_LT(squares / turns, 1.5) << tilt;
    EXPECT_GT(squares / turns, tilt < kDegree ? 0.1 : 0.5) << tilt;
    EXPECT_LT(most, 5.0) << tilt;
  }
}

TEST(MountingSearch, AnEvenSpeedOnAStraightLineShowsNothing) {
  Robot robot(1, 0.2 * kDegree, false);
  MountingSearch search;
  for (int state = 0; state < 3000; ++state) {
    robot.move(search, about_up(1.0));
    EXPECT_FALSE(search.take_turn());
  }
  EXPECT_EQ(search.yaw_sigma(), MountingSearch::kUniform);
}

// The robot began on a slope, so that what was taken for up is not: the mean over the drive is.
TEST(MountingSearch, TheMeanOfTheDriveIsLevel) {
  const Matrix3d R_slope =
      AngleAxisd(5 * kDegree, Vector3d(1, 2, 0).normalized()).toRotationMatrix();
  Robot robot(3, 0.2 * kDegree);
  MountingSearch search;
  const Matrix3d R = robot.drive(search, R_slope * about_up(2.0), 300);
  EXPECT_LT(std::acos(R(2, 2)), 1 * kDegree);
}

// 100 robots on ground that tilts them.
TEST(MountingSearch, RightAxesAreNeverContradicted) {
  int doubted = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    Robot robot(seed, 3 * kDegree);
    MountingSearch search(true);
    const Matrix3d vague = about_up(8 * kDegree * std::sin(seed));  // by eye
    for (int state = 0; state < 600; ++state) {
      robot.move(search, vague);
      EXPECT_FALSE(search.take_turn()) << seed;
      EXPECT_FALSE(search.is_contradicted()) << seed;
      doubted += search.known() ? 0 : 1;
    }
  }
  EXPECT_LT(doubted, 0.01 * 100 * 600);
}

// What the first seconds contradict, a wheel that spins or a robot that is lifted, the drive shows
// to be right.
TEST(MountingSearch, RightAxesCountAgain) {
  Robot robot(7, 0.5 * kDegree);
  MountingSearch search(true);
  bool contradicted = false;
  for (int state = 0; state < 600; ++state) {
    robot.move_with(search, about_up(contradicted ? 0.0 : M_PI / 2), Matrix3d::Identity());
    contradicted |= !search.known();
    EXPECT_FALSE(search.take_turn());
  }
  EXPECT_TRUE(contradicted);
  EXPECT_TRUE(search.known());
}

TEST(MountingSearch, OtherAxesThanConfiguredAreFound) {
  for (const double yaw : {M_PI / 2, M_PI, -2.0}) {
    Robot robot(5, 0.5 * kDegree);
    MountingSearch search(true);
    const Matrix3d R = robot.drive(search, about_up(yaw), 600);
    EXPECT_FALSE(search.is_configured());
    EXPECT_LT(std::abs(wrapped(std::atan2(R(1, 0), R(0, 0)))), 5 * kDegree) << yaw;
  }
}

// No rotation is right, so none is used.
TEST(MountingSearch, AWrongSignIsNoMountingButIsNoticed) {
  Robot robot(6, 0.5 * kDegree);
  MountingSearch search(true);
  const Matrix3d reversed = Vector3d(-1, 1, 1).asDiagonal();
  for (int state = 0; state < 600; ++state) {
    robot.move_with(search, reversed, Matrix3d::Identity());
    EXPECT_FALSE(search.take_turn());
  }
  EXPECT_FALSE(search.known());
}

TEST(MountingSearch, WhatAnEarlierRunHasFoundIsKnownAtOnce) {
  MountingSearch search;
  search.resume(0.1);
  EXPECT_TRUE(search.known());
  EXPECT_FALSE(search.take_turn());
  MountingSearch vague;
  vague.resume(1.0);
  EXPECT_FALSE(vague.known());
}

}  // namespace
}  // namespace gprodom
