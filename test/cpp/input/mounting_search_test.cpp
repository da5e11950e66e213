// Robots whose IMU is mounted in an unknown way.
#include "input/mounting_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

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
      MotionStep step;
      step.dt = 0.02;
      step.acceleration = of_force * (force + normal_.vector(0.05));
      step.angular_velocity = of_rate * Vector3d(0, 0, rate_);
      steps.push_back(step);
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
