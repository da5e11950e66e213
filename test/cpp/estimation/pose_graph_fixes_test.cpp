// Fixes as edges of the pose graph.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "estimation/graph/planar_factors.h"
#include "estimation/graph/pose_graph.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 0.5;  // m between nodes

// Ahead by a node's distance, as a wheel of that scale reports it.
PlanarStep straight(double scale) {
  PlanarStep step;
  step.measured.p = {scale * kStep, 0.0};
  step.d_scale.head<2>() = -step.measured.p;
  return step;
}

// A fix's residual against differences of itself.
TEST(PoseGraph, FixDerivatives) {
  FixEdge fix;
  fix.at = {{0.4, -0.7}, 0.3};
  fix.way = {{0.3, 0.1}, false};
  fix.p = {1.0, 2.0};
  fix.covariance << 0.04, 0.01, 0.01, 0.09;
  const PlanarPose node{{0.5, 1.5}, 0.8};
  const FixResidual found(fix, node, 0.1);
  constexpr double kBy = 1e-6;
  for (int k = 0; k < 4; ++k) {
    const auto at = [&](double by) {
      PlanarPose moved = node;
      if (k < 2) moved.p[k] += by;
      if (k == 2) moved.yaw += by;
      return FixResidual(fix, moved, k == 3 ? 0.1 + by : 0.1).value;
    };
    const Eigen::Vector2d numeric = (at(kBy) - at(-kBy)) / (2 * kBy);
    EXPECT_LT((numeric - found.J.col(k)).norm(), 1e-7) << k;
  }
}

// Two fixes far from each other: the wheel's scale, and the track in their frame.
TEST(PoseGraph, FixesAtBothEndsGiveTheScale) {
  constexpr double kLength = 90.0, kSigma = 0.02;
  PoseGraph graph(PlanarPose(), {});
  PlanarStep step = straight(1.02);  // the wheel reports 2 % too much
  step.covariance = Vector3d(1e-6, 1e-6, 1e-8).asDiagonal();
  for (int i = 0; i < kLength / kStep; ++i) graph.add_node(step);
  graph.set_first_prior(Vector3d(1e8, 1e8, 10).asDiagonal());
  std::vector<FixEdge> fixes(2);
  fixes[1].node = static_cast<std::size_t>(kLength / kStep);
  fixes[1].p = {0.0, kLength};
  for (FixEdge& fix : fixes) fix.covariance *= kSigma * kSigma;
  graph.move({{0, 0}, M_PI / 2});
  graph.set_first_prior(Vector3d(1e8, 1e8, 10).asDiagonal());
  graph.set_fixes(fixes);
  const PoseGraphSolution solution = graph.solve(1.0, 0.03);
  EXPECT_NEAR(solution.newest.scale, 1.02, 0.001);
  EXPECT_LT((solution.newest.pose.p - Eigen::Vector2d(0.0, kLength)).norm(), 0.01);
  const double odometry = std::sqrt(1e-6 * kLength / kStep);
  EXPECT_NEAR(std::sqrt(solution.newest.covariance(3, 3)),
              std::hypot(std::sqrt(2.0) * kSigma, odometry) / kLength, 2e-5);
}

// Errors that last: a thousand fixes of one place, each second, are worth what the sum of the
// inverse of their covariance says, t / (2 T) + 1 for T much longer than a step.
TEST(PoseGraph, FixesWithAnErrorThatLastsAreWorthLess) {
  constexpr double kSigma = 1.0, kLasts = 100.0;
  constexpr int kFixes = 1000;
  PoseGraph graph(PlanarPose(), {});
  PlanarStep step = straight(1.0);
  step.covariance = Vector3d(1e-10, 1e-10, 1e-12).asDiagonal();
  graph.add_node(step);
  graph.set_first_prior(Vector3d(1e8, 1e8, 1e-8).asDiagonal());
  std::vector<FixEdge> fixes(kFixes);
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    fixes[i].white = 0.01;
    if (i > 0) fixes[i].before = i - 1, fixes[i].kept = std::exp(-1 / kLasts);
  }
  graph.set_fixes(fixes);
  const Matrix5d covariance = graph.solve(1.0, 0.0).newest.covariance;
  EXPECT_NEAR(kSigma * kSigma / covariance(0, 0), 1 + kFixes / (2 * kLasts), 0.4);
}

}  // namespace
}  // namespace gprodom
