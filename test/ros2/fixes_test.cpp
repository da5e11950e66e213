// What both ROS nodes make of positions from outside.
#include "fixes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "messages.h"

namespace gprodom::ros_shared {
namespace {

ros2::NavSatFix navsat(int status, double sigma, int type) {
  ros2::NavSatFix m;
  m.status.status = static_cast<std::int8_t>(status);
  m.latitude = 52.0, m.longitude = 13.0, m.altitude = 40.0;
  m.position_covariance = {sigma * sigma,    0, 0, 0, sigma * sigma, 0.001, 0, 0.001,
                           4 * sigma * sigma};
  m.position_covariance_type = static_cast<std::uint8_t>(type);
  return m;
}

ros2::PoseWithCovariance pose(double sigma, double heading_sigma, double yaw) {
  ros2::PoseWithCovariance m;
  m.pose.position = {1.0, 2.0, 3.0};
  m.pose.orientation = {0.0, 0.0, std::sin(yaw / 2), std::cos(yaw / 2)};
  m.covariance[0] = m.covariance[7] = m.covariance[14] = sigma * sigma;
  m.covariance[35] = heading_sigma * heading_sigma;
  return m;
}

TEST(NavSatFix, StatusIsQuality) {
  EXPECT_EQ(to_fix(7, navsat(-1, 0.02, 2)).quality, FixQuality::kNone);
  EXPECT_EQ(to_fix(7, navsat(0, 0.02, 2)).quality, FixQuality::kSingle);
  EXPECT_EQ(to_fix(7, navsat(1, 0.02, 2)).quality, FixQuality::kSingle);
  EXPECT_EQ(to_fix(7, navsat(2, 0.02, 2)).quality, FixQuality::kFixed);
  EXPECT_EQ(to_fix(7, navsat(2, 0.2, 2)).quality, FixQuality::kFloat);
}

TEST(NavSatFix, IsGeodeticWithItsCovariance) {
  const PositionFix fix = to_fix(7, navsat(0, 2.0, 2));
  EXPECT_EQ(fix.time, 7);
  EXPECT_EQ(fix.frame, FixFrame::kGeodetic);
  EXPECT_EQ(fix.position, Eigen::Vector3d(52, 13, 40));
  EXPECT_DOUBLE_EQ(fix.covariance(0, 0), 4.0);
  EXPECT_DOUBLE_EQ(fix.covariance(1, 2), 0.001);
  EXPECT_DOUBLE_EQ(fix.covariance(2, 2), 16.0);
  EXPECT_FALSE(fix.has_heading);
}

TEST(NavSatFix, UnknownCovarianceIsNotBelieved) {
  const PositionFix fix = to_fix(7, navsat(2, 0.02, 0));
  EXPECT_EQ(fix.quality, FixQuality::kFloat);
  EXPECT_DOUBLE_EQ(fix.covariance(0, 0), 1.0);
  EXPECT_DOUBLE_EQ(fix.covariance(2, 2), 4.0);
  EXPECT_DOUBLE_EQ(to_fix(7, navsat(0, 0.0, 2)).covariance(0, 0), 25.0);
}

TEST(NavSatFix, NotANumberIsNoPosition) {
  ros2::NavSatFix m = navsat(2, 0.02, 2);
  m.altitude = std::numeric_limits<double>::quiet_NaN();
  const PositionFix fix = to_fix(7, m);
  EXPECT_EQ(fix.quality, FixQuality::kNone);
  EXPECT_TRUE(fix.position.allFinite());
}

TEST(SitePose, HasItsHeading) {
  const PositionFix fix = to_site_fix(7, pose(0.02, 0.1, 0.7));
  EXPECT_EQ(fix.frame, FixFrame::kSite);
  EXPECT_EQ(fix.quality, FixQuality::kFixed);
  EXPECT_EQ(fix.position, Eigen::Vector3d(1, 2, 3));
  ASSERT_TRUE(fix.has_heading);
  EXPECT_NEAR(fix.heading, 0.7, 1e-12);
  EXPECT_DOUBLE_EQ(fix.heading_sigma, 0.1);
}

TEST(SitePose, WithoutCovariancesIsFloatWithoutHeading) {
  const PositionFix fix = to_site_fix(7, pose(0.0, 0.0, 0.7));
  EXPECT_EQ(fix.quality, FixQuality::kFloat);
  EXPECT_DOUBLE_EQ(fix.covariance(0, 0), 1.0);
  EXPECT_FALSE(fix.has_heading);
}

}  // namespace
}  // namespace gprodom::ros_shared
