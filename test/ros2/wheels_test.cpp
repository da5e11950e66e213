// What both ROS nodes make of the wheel's messages.
#include "wheels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gprodom::ros_shared {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr TimeNs kSecond = 1'000'000'000;

Eigen::Quaterniond heading(double yaw) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

TEST(WheelOdometry, IsTheChordAlongTheHeadingHalfway) {
  WheelOdometry wheel;
  EXPECT_EQ(wheel.add(1, {5, 5, 0}, heading(0)).distance_m, 0.0);
  EXPECT_DOUBLE_EQ(wheel.add(2, {6, 5, 0}, heading(0)).distance_m, 1.0);
  EXPECT_DOUBLE_EQ(wheel.add(3, {5.5, 5, 0}, heading(0)).distance_m, 0.5);  // backwards
  EXPECT_DOUBLE_EQ(wheel.add(4, {6.5, 6, 0}, heading(M_PI / 2)).distance_m, 0.5 + std::sqrt(2.0));
}

TEST(WheelOdometry, WhatIsNotFiniteIsSaidAndForgotten) {
  WheelOdometry wheel;
  wheel.add(1, {0, 0, 0}, heading(0));
  EXPECT_TRUE(std::isnan(wheel.add(2, {kNan, 0, 0}, heading(0)).distance_m));
  EXPECT_TRUE(std::isnan(wheel.add(3, {1e300, 1e300, 0}, heading(0)).distance_m));
  EXPECT_TRUE(std::isnan(wheel.add(4, {1, 0, 0}, {kNan, 0, 0, 0}).distance_m));
  EXPECT_DOUBLE_EQ(wheel.add(5, {2, 0, 0}, heading(0)).distance_m, 2.0);
}

TEST(WheelOdometry, AFirstPoseThatIsNotFiniteIsNoFirstPose) {
  WheelOdometry wheel;
  EXPECT_TRUE(std::isnan(wheel.add(1, {kNan, 0, 0}, heading(0)).distance_m));
  EXPECT_EQ(wheel.add(2, {7, 0, 0}, heading(0)).distance_m, 0.0);
  EXPECT_DOUBLE_EQ(wheel.add(3, {8, 0, 0}, heading(0)).distance_m, 1.0);
}

TEST(Integral, IsTrapezoidalAndForgetsWhatIsNotFinite) {
  Integral sum;
  EXPECT_EQ(sum.add(0, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(sum.add(kSecond, 3.0), 2.0);
  EXPECT_TRUE(std::isnan(sum.add(2 * kSecond, kNan)));
  EXPECT_TRUE(std::isnan(sum.add(3 * kSecond, std::numeric_limits<double>::infinity())));
  EXPECT_DOUBLE_EQ(sum.add(4 * kSecond, 1.0), 8.0);  // 2 m/s for the 3 s since the last good one
}

TEST(Wheels, LieHalfTheTrackAside) {
  const WheelsSample sides = to_wheels({5, 10.0}, 0.5, 0.4);
  EXPECT_DOUBLE_EQ(sides.left_m, 9.9);
  EXPECT_DOUBLE_EQ(sides.right_m, 10.1);
}

TEST(Joints, AreFoundByName) {
  const std::vector<std::string> names = {"arm", "a", "b", "c"};
  const std::vector<double> angles = {9.0, 1.0, 3.0};  // fewer than names, as hostile ones have
  EXPECT_DOUBLE_EQ(to_sample(1, names, angles, "a", 0.5)->distance_m, 0.5);
  EXPECT_FALSE(to_sample(1, names, angles, "c", 0.5));
  EXPECT_FALSE(to_sample(1, names, angles, "d", 0.5));
  const auto sides = to_sample(1, names, angles, {"a", "b"}, {"b"}, 0.5);
  ASSERT_TRUE(sides);
  EXPECT_DOUBLE_EQ(sides->left_m, 1.0);
  EXPECT_DOUBLE_EQ(sides->right_m, 1.5);
  EXPECT_FALSE(to_sample(1, names, angles, {"a"}, {"c"}, 0.5));
}

}  // namespace
}  // namespace gprodom::ros_shared
