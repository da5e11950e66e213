// Messages of different sensors that overtake each other on their way.
#include <gtest/gtest.h>

#include <deque>
#include <utility>

#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"

namespace gprodom {
namespace {

// The published poses if each sample of the wheel comes so many IMU samples late.
std::vector<OdometryEstimate> poses(std::size_t late) {
  Odometry odometry(default_config({"gpr.enabled=false"}));
  std::deque<WheelSample> on_the_way;
  std::vector<OdometryEstimate> found;
  for (const Input& input : there_and_back(1)) {
    if (const auto* wheel = std::get_if<WheelSample>(&input)) {
      on_the_way.push_back(*wheel);
      if (on_the_way.size() > late) {
        odometry.add(on_the_way.front());
        on_the_way.pop_front();
      }
    }
    if (const auto* imu = std::get_if<ImuSample>(&input)) odometry.add(*imu);
    for (const OdometryEstimate& pose : odometry.step().odometry) found.push_back(pose);
  }
  return found;
}

// The pose uses wheel samples between two solutions, so an IMU message that comes before or after
// one of them could change it: then a ROS node would differ from the replay of its log.
TEST(Arrival, WheelThatComesAFewImuSamplesLateChangesNoPose) {
  const auto in_order = poses(0), late = poses(4);
  ASSERT_EQ(in_order.size(), late.size());
  ASSERT_GT(in_order.size(), 3000U);
  for (std::size_t i = 0; i < in_order.size(); ++i) {
    ASSERT_EQ(in_order[i].time, late[i].time);
    ASSERT_EQ(in_order[i].p_odom_body, late[i].p_odom_body) << i;
    ASSERT_EQ(in_order[i].pose_covariance, late[i].pose_covariance) << i;
  }
}

}  // namespace
}  // namespace gprodom
