#include "pipeline/map_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

// Covariance against sampled errors: both poses disturbed as their covariances say, in their
// convention (position, and rotation on the left, in the frame's axes).
TEST(MapFrame, CovarianceMatchesSampledErrors) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  auto vector6 = [&] {
    Eigen::Matrix<double, 6, 1> v;
    for (int i = 0; i < 6; ++i) v[i] = normal(random);
    return v;
  };
  auto rotated = [](const Eigen::Vector3d& r, const Eigen::Quaterniond& q) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(r.norm(), r.normalized())) * q;
  };
  Matrix6d root_odom, root_correction;
  for (int i = 0; i < 6; ++i) root_odom.col(i) = 0.003 * vector6();
  for (int i = 0; i < 6; ++i) root_correction.col(i) = 0.003 * vector6();

  OdometryEstimate estimate = estimate_at(0);
  estimate.p_odom_body = {3, -2, 0.5};
  estimate.q_odom_body = rotated({0.3, -0.2, 1.0}, yaw(0.4));
  estimate.pose_covariance = root_odom * root_odom.transpose();
  Correction correction = correction_at(0, 5);
  correction.q_map_odom = rotated({-0.1, 0.2, 0.7}, yaw(0.1));
  correction.covariance = root_correction * root_correction.transpose();
  const OdometryEstimate mean = in_map(correction, estimate);

  constexpr int kSamples = 20000;
  Matrix6d sampled = Matrix6d::Zero();
  for (int n = 0; n < kSamples; ++n) {
    const Eigen::Matrix<double, 6, 1> e = root_odom * vector6();
    const Eigen::Matrix<double, 6, 1> c = root_correction * vector6();
    OdometryEstimate disturbed = estimate;
    disturbed.p_odom_body += e.head<3>();
    disturbed.q_odom_body = rotated(e.tail<3>(), estimate.q_odom_body);
    Correction other = correction;
    other.p_map_odom += c.head<3>();
    other.q_map_odom = rotated(c.tail<3>(), correction.q_map_odom);
    const OdometryEstimate placed = in_map(other, disturbed);
    const Eigen::AngleAxisd turn(placed.q_odom_body * mean.q_odom_body.conjugate());
    Eigen::Matrix<double, 6, 1> error;
    error << placed.p_odom_body - mean.p_odom_body, turn.angle() * turn.axis();
    sampled += error * error.transpose() / kSamples;
  }
  // Sampling leaves about sqrt(2 / kSamples) = 1 %.
  EXPECT_LT((sampled - mean.pose_covariance).norm(), 0.05 * mean.pose_covariance.norm());
}

}  // namespace
}  // namespace gprodom
