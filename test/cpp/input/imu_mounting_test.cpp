#include "input/imu_mounting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

}  // namespace
}  // namespace gprodom
