// Positions from outside: `map` becomes `site`, also without a radar, and `odom` does not know it.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"
#include "support/told.h"

namespace gprodom {
namespace {

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
  const auto &odom = with.out.odometry, &as_before = without.out.odometry;
  ASSERT_EQ(odom.size(), as_before.size());
  for (std::size_t i = 0; i < odom.size(); ++i)
    ASSERT_EQ(odom[i].p_odom_body, as_before[i].p_odom_body);
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
