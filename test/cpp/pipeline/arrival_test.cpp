// Messages of different sensors that overtake each other on their way.
#include <gtest/gtest.h>

#include <deque>
#include <vector>

#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"
#include "support/told.h"

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
  EXPECT_GT(in_order.size(), 3000U);
  EXPECT_TRUE(same_poses(in_order, late));
}

// Positions from outside: `map` becomes `site`, also without a radar, and `odom` does not know it.
struct Driven {
  Outputs out;
  std::vector<OdometryEstimate> smoothed;
};

// There and back on 9 m, in site towards (cos 1, sin 1) from (100, 50). with_fixes: each second,
// exact.
Driven driven(bool with_fixes) {
  Odometry odometry(default_config({"gpr.enabled=false"}));
  odometry.record();
  Driven run;
  const auto inputs = there_and_back(3);
  for (const Input& input : with_fixes ? fixed(inputs) : inputs) {
    give(odometry, input);
    append(run.out, odometry.step());
  }
  append(run.out, odometry.finish());
  run.smoothed = odometry.smoothed();
  return run;
}

TEST(Fixes, TurnMapToSiteAndLeaveOdomAsItIs) {
  const Driven with = driven(true), without = driven(false);
  EXPECT_TRUE(same_poses(with.out.odometry, without.out.odometry));
  const Eigen::Vector3d home(100, 50, 0);
  const OdometryEstimate& in_map = with.out.odometry_in_map.back();
  EXPECT_LT((in_map.p_odom_body - home).norm(), 0.1);
  EXPECT_NEAR(std::abs(in_map.q_odom_body.z()), std::sin(0.5), 0.02);
  EXPECT_LT((with.smoothed.back().p_odom_body - home).norm(), 0.05);
  EXPECT_LT((with.smoothed.front().p_odom_body - home).norm(), 0.05);
  EXPECT_LT(without.out.odometry_in_map.back().p_odom_body.norm(), 1.0) << "map stays odom";
  EXPECT_EQ(count_with(reasons_in(with.out), "fixes"), 0);
}

}  // namespace
}  // namespace gprodom
