// Positions from outside: `map` becomes `site`, also without a radar, and `odom` does not know it.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"

namespace gprodom {
namespace {

struct Driven {
  std::vector<OdometryEstimate> odom, map, smoothed;
  std::vector<std::string> warnings, reasons;
};

// There and back on 9 m, in site towards (cos 1, sin 1) from (100, 50). with_fixes: each second,
// exact, until `until_s`.
Driven driven(bool with_fixes, double until_s = 100.0) {
  Odometry odometry(default_config({"gpr.enabled=false"}));
  odometry.record();
  Driven run;
  const auto take = [&](const Outputs& out) {
    run.odom.insert(run.odom.end(), out.odometry.begin(), out.odometry.end());
    run.map.insert(run.map.end(), out.odometry_in_map.begin(), out.odometry_in_map.end());
    run.warnings.insert(run.warnings.end(), out.warnings.begin(), out.warnings.end());
    for (const Status& status : out.status)
      run.reasons.insert(run.reasons.end(), status.reasons.begin(), status.reasons.end());
  };
  int wheels = 0;
  for (const Input& input : there_and_back(3)) {
    if (const auto* imu = std::get_if<ImuSample>(&input)) odometry.add(*imu);
    if (const auto* wheel = std::get_if<WheelSample>(&input)) {
      odometry.add(*wheel);
      const double since = to_seconds(wheel->time - kDriveStart);
      if (with_fixes && ++wheels % 100 == 0 && since < until_s) {
        odometry.add(fix_at(*wheel));
      }
    }
    take(odometry.step());
  }
  take(odometry.finish());
  run.smoothed = odometry.smoothed();
  return run;
}

TEST(Fixes, TurnMapToSiteAndLeaveOdomAsItIs) {
  const Driven with = driven(true), without = driven(false);
  ASSERT_EQ(with.odom.size(), without.odom.size());
  for (std::size_t i = 0; i < with.odom.size(); ++i)
    ASSERT_EQ(with.odom[i].p_odom_body, without.odom[i].p_odom_body);
  const Eigen::Vector3d home(100, 50, 0);
  EXPECT_LT((with.map.back().p_odom_body - home).norm(), 0.1);
  EXPECT_NEAR(std::abs(with.map.back().q_odom_body.z()), std::sin(0.5), 0.02);
  EXPECT_LT((with.smoothed.back().p_odom_body - home).norm(), 0.05);
  EXPECT_LT((with.smoothed.front().p_odom_body - home).norm(), 0.05);
  EXPECT_LT(without.map.back().p_odom_body.norm(), 1.0) << "map stays odom without fixes";
  for (const std::string& reason : with.reasons) EXPECT_EQ(reason.find("fixes"), reason.npos);
}

}  // namespace
}  // namespace gprodom
