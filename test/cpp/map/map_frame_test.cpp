#include "map/map_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/graph/pose_graph.h"
#include "support/noise.h"

namespace gprodom {
namespace {

Eigen::Quaterniond yaw(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

OdometryEstimate estimate_at(TimeNs time) {
  OdometryEstimate estimate;
  estimate.time = time;
  estimate.p_odom_body = {1, 0, 0};
  return estimate;
}

Correction correction_at(TimeNs time, double x) {
  Correction correction;
  correction.time = time;
  correction.p_map_odom = {x, 0, 0};
  correction.q_map_odom = yaw(M_PI / 2);
  return correction;
}

TEST(MapFrame, CorrectionIsInForceFromItsTimeOn) {
  MapFrame frame;
  Outputs outputs;
  outputs.odometry = {estimate_at(10), estimate_at(20), estimate_at(30)};
  outputs.corrections = {correction_at(20, 5), correction_at(45, 7)};
  const auto first = frame.place(outputs);
  EXPECT_EQ(first[0].p_odom_body, Eigen::Vector3d(1, 0, 0));
  EXPECT_LT((first[1].p_odom_body - Eigen::Vector3d(5, 1, 0)).norm(), 1e-15);
  EXPECT_LT(first[2].q_odom_body.angularDistance(yaw(M_PI / 2)), 1e-15);

  outputs.corrections.clear();
  outputs.odometry = {estimate_at(40), estimate_at(50)};
  const auto second = frame.place(outputs);
  EXPECT_NEAR(second[0].p_odom_body.x(), 5, 1e-15);
  EXPECT_NEAR(second[1].p_odom_body.x(), 7, 1e-15);

  frame.reset();
  EXPECT_EQ(frame.place(outputs)[0].p_odom_body, Eigen::Vector3d(1, 0, 0));
}

// Covariance against sampled errors, exactly composed: an odometry with an error where the
// correction was made (which the correction takes back), and one that it has added since; a map
// with an error of its own at that place.
TEST(MapFrame, CovarianceMatchesSampledErrors) {
  Noise normal(7);
  const auto draw = [&](const Eigen::Matrix3d& root) -> Eigen::Vector3d {
    const Eigen::Vector3d e(normal(), normal(), normal());
    return root * e;
  };
  Eigen::Matrix3d root_before, root_added, root_map;
  for (Eigen::Matrix3d* root : {&root_before, &root_added, &root_map}) {
    *root = 0.003 * Eigen::Matrix3d::NullaryExpr([&] { return normal(); });
  }
  const PlanarPose since{{3, -2}, 0.4}, step{{1.5, 0.7}, 0.8};
  const PlanarPose here = compose(since, step), origin_in_map{{5, 1}, 1.1};

  // Errors of a pose add to it in the axes of its frame.
  const auto disturbed = [](PlanarPose pose, const Eigen::Vector3d& e) {
    pose.p += e.head<2>();
    pose.yaw += e[2];
    return pose;
  };
  constexpr int kSamples = 20000;
  Eigen::Matrix3d odom = Eigen::Matrix3d::Zero(), map = Eigen::Matrix3d::Zero();
  for (int n = 0; n < kSamples; ++n) {
    const PlanarPose seen_since = disturbed(since, draw(root_before));
    const PlanarPose seen_here = compose(seen_since, disturbed(step, draw(root_added)));
    const PlanarPose map_since = disturbed(compose(origin_in_map, since), draw(root_map));
    const PlanarPose map_here = compose(map_since, between(seen_since, seen_here));
    const PlanarPose true_here = compose(origin_in_map, here);
    Eigen::Vector3d e, m;
    e << seen_here.p - here.p, seen_here.yaw - here.yaw;
    m << map_here.p - true_here.p, std::remainder(map_here.yaw - true_here.yaw, 2 * M_PI);
    odom += e * e.transpose() / kSamples;
    map += m * m.transpose() / kSamples;
  }

  const auto estimate = [](const PlanarPose& pose, const Eigen::Matrix3d& covariance) {
    OdometryEstimate x;
    x.p_odom_body << pose.p, 0.0;
    set_planar_block(covariance, x.pose_covariance);
    return x;
  };
  Correction correction;
  correction.q_map_odom = yaw(origin_in_map.yaw);
  correction.p_map_odom << origin_in_map.p, 0.0;
  const Eigen::Matrix3d carried = carried_covariance(
      correction, root_map * root_map.transpose(),
      estimate(since, root_before * root_before.transpose()), estimate(here, odom));
  // Sampling leaves about sqrt(2 / kSamples) = 1 %.
  EXPECT_LT((carried - map).norm(), 0.05 * map.norm());
}

// What is told of a pose that the correction was made for is the correction's own covariance.
TEST(MapFrame, CovarianceAtTheCorrectionIsThatOfTheCorrection) {
  MapFrame frame;
  Outputs outputs;
  outputs.odometry = {estimate_at(20)};
  outputs.odometry[0].pose_covariance = 4e-4 * Matrix6d::Identity();
  outputs.corrections = {correction_at(20, 5)};
  outputs.corrections[0].covariance = 1e-4 * Matrix6d::Identity();
  const Matrix6d covariance = frame.place(outputs)[0].pose_covariance;
  Matrix6d expected = 4e-4 * Matrix6d::Identity();  // height, roll and pitch are odometry's
  set_planar_block(1e-4 * Eigen::Matrix3d::Identity(), expected);
  EXPECT_LT((covariance - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace gprodom
