#include "estimation/graph/pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "estimation/graph/planar_factors.h"

namespace gprodom {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kStep = 0.5;  // m between nodes

// A line driven there and back `passes` times, 20 m each way, turning on the spot at its ends, with
// seeded errors of odometry and of its scale. Revisits of the first pass, every 2 m.
struct Drive {
  PoseGraphOptions options;
  double scale_sigma;
  std::vector<PlanarPose> truth;
  PoseGraph graph;
  PoseGraphSolution solve() { return graph.solve(1.0, scale_sigma); }
  Drive(unsigned seed, int passes, double scale_sigma, bool with_revisits);
};

Matrix3d step_covariance() { return Vector3d(4e-5, 1e-5, 4e-6).asDiagonal(); }

// As odometry of scale 1 takes it.
PlanarStep step_of(const PlanarPose& measured) {
  PlanarStep step{measured, 1.0, Vector3d::Zero(), step_covariance()};
  step.d_scale.head<2>() = -measured.p;
  return step;
}

Drive::Drive(unsigned seed, int passes, double sigma, bool with_revisits)
    : options([&] {
        PoseGraphOptions o;
        o.revisit_yaw_sigma =
            10;  // loose: the places of this drive are exact and would falsify the statistics
        return o;
      }()),
      scale_sigma(sigma),
      truth{PlanarPose()},
      graph(PlanarPose(), options) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  const double scale_error = scale_sigma * normal(engine);
  auto go = [&](const PlanarPose& step) {
    truth.push_back(compose(truth.back(), step));
    PlanarPose seen = step;
    seen.p *= 1 + scale_error;
    const Vector3d sigma = step_covariance().diagonal().cwiseSqrt();
    seen.p.x() += sigma[0] * normal(engine);
    seen.p.y() += sigma[1] * normal(engine);
    seen.yaw += sigma[2] * normal(engine);
    return graph.add_node(step_of(seen));
  };
  for (int pass = 0; pass < passes; ++pass) {
    for (int i = 0; i < 40; ++i) {
      const std::size_t node = go({{kStep, 0}, 0});
      if (!with_revisits || pass == 0 || i % 4 != 0) continue;
      const auto memory = static_cast<std::size_t>(pass % 2 == 0 ? i + 1 : 40 - i - 1);
      RevisitEdge edge{memory, node};
      edge.mirrored = pass % 2 == 1;
      const PlanarPose there = between(truth[memory], truth[node]);
      edge.offset_m = there.p.x() + edge.sigma_m * normal(engine);
      edge.lateral_m = there.p.y() + edge.lateral_sigma_m * normal(engine);
      graph.add_revisit(edge);
    }
    go({{0, 0}, M_PI});
  }
}

Vector3d newest_error(const Drive& drive, const PoseGraphSolution& solution) {
  const PlanarPose& a = solution.nodes.back();
  const PlanarPose& b = drive.truth.back();
  Vector3d error;
  error << a.p - b.p, wrapped(a.yaw - b.yaw);
  return error;
}

TEST(PoseGraph, DerivativesAreThoseOfTheResiduals) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-3, 3);
  WhitenedStep step{step_of({{0.7, -0.2}, 2.9}), Matrix3d::Zero()};
  step.whitening << 3, 0, 0, 1, 2, 0, 0.5, -1, 4;
  step.odometry.d_scale << -0.7, 0.1, 0.05;
  RevisitEdge edge{0, 1, {{0.1, 0.2}, -0.3}, {{-0.2, 0.1}, 0.4}};
  edge.mirrored = true;
  edge.memory_way.p << 0.15, 0.1;
  edge.query_way.p << -0.2, 0.05;
  using Unknowns = Eigen::Matrix<double, 8, 1>;  // two poses, and scale and slip, or two slips
  const auto residual = [&](const Unknowns& x, bool revisit) {
    const PlanarPose a{x.segment<2>(0), x[2]}, b{x.segment<2>(3), x[5]};
    return revisit ? revisit_residual(edge, 0.3, a, b, x[6], x[7])
                   : step_residual(step, a, b, x[6], x[7]);
  };
  for (int trial = 0; trial < 40; ++trial) {
    const bool revisit = trial % 2 == 1;
    Unknowns at;
    for (double& value : at) value = uniform(engine);
    const PlanarResidual analytic = residual(at, revisit);
    for (int k = 0; k < 8; ++k) {
      const Unknowns change = 1e-6 * Unknowns::Unit(k);
      const Vector3d numeric =
          (residual(at + change, revisit).value - residual(at - change, revisit).value) / 2e-6;
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(numeric[i], analytic.J(i, k), 1e-6 * (1 + std::abs(analytic.J(i, k))))
            << (revisit ? "revisit" : "step") << ", residual " << i << " by " << k;
      }
    }
  }
}

TEST(PoseGraph, CovarianceIsTrue) {
  for (const bool with_revisits : {false, true}) {
    double nees = 0;
    constexpr int kRuns = 800;
    for (unsigned seed = 0; seed < kRuns; ++seed) {
      Drive drive(seed, 3, 0.01, with_revisits);
      const auto solution = drive.solve();
      const Vector3d error = newest_error(drive, solution);
      const Matrix3d covariance = solution.newest.covariance.topLeftCorner<3, 3>();
      nees += error.dot(covariance.inverse() * error) / kRuns;
    }
    // Chi-square of 600 degrees of freedom over 200: 99 % within 2.57 to 3.46. A robust kernel
    // loses a little of the information.
    EXPECT_GT(nees, 2.5) << with_revisits;
    EXPECT_LT(nees, 3.6) << with_revisits;
  }
}

TEST(PoseGraph, RevisitsTakeTheDriftAway) {
  double without = 0, with = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Drive plain(seed, 6, 0.01, false), tied(seed, 6, 0.01, true);
    without += newest_error(plain, plain.solve()).head<2>().norm() / 20;
    with += newest_error(tied, tied.solve()).head<2>().norm() / 20;
  }
  // What is left is the scale of the first pass, which no revisit sees: the end is at the start.
  EXPECT_LT(with, 0.4 * without);
}

TEST(PoseGraph, WrongRevisitsAreLeftOut) {
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> off(0.3, 3.0);
  for (unsigned seed = 0; seed < 10; ++seed) {
    Drive drive(seed, 4, 0.01, true);
    const auto clean = drive.solve();
    const std::size_t honest = drive.graph.revisits().size();
    // Single ones 0.3 to 3 m off, and three that agree with each other, a rebar pitch off.
    for (const std::size_t node : {60, 100, 140}) {
      RevisitEdge wrong{10, node};
      wrong.offset_m =
          between(drive.truth[10], drive.truth[node]).p.x() + (node % 40 ? 1 : -1) * off(engine);
      drive.graph.add_revisit(wrong);
    }
    for (const std::size_t node : {88, 89, 90}) {
      RevisitEdge wrong{node - 82, node};
      wrong.offset_m = between(drive.truth[node - 82], drive.truth[node]).p.x() + 0.15;
      drive.graph.add_revisit(wrong);
    }
    const auto solution = drive.solve();
    EXPECT_LT((solution.nodes.back().p - clean.nodes.back().p).norm(), 0.02);
    for (std::size_t i = honest; i < drive.graph.revisits().size(); ++i) {
      EXPECT_FALSE(solution.trusted[i]) << i - honest;
    }
  }
}

// All nodes at the end of a revisit stay, and every other node of a pass over known ground.
std::vector<bool> thinned(const PoseGraph& graph, bool with_revisits) {
  std::vector<bool> keep(graph.nodes().size());
  keep.front() = keep.back() = true;
  for (const RevisitEdge& edge : graph.revisits()) keep[edge.memory] = true;
  for (std::size_t i = 0; i < graph.revisits().size(); ++i) {
    const std::size_t query = graph.revisits()[i].query;
    keep[query] = keep[query] || with_revisits || i % 2 == 0;
  }
  return keep;
}

TEST(PoseGraph, NodesWithoutRevisitsGoWithoutLoss) {
  Drive drive(7, 3, 0.01, true);
  const PlanarEstimate whole = drive.solve().newest;
  drive.graph.keep_only(thinned(drive.graph, true));
  EXPECT_LT(drive.graph.nodes().size(), 50U);
  EXPECT_EQ(drive.graph.revisits().size(), 20U);
  const PlanarEstimate left = drive.solve().newest;
  EXPECT_LT((whole.pose.p - left.pose.p).norm(), 1e-3);
  EXPECT_NEAR(whole.pose.yaw, left.pose.yaw, 1e-3);
  EXPECT_LT((whole.covariance - left.covariance).norm(), 0.02 * whole.covariance.norm());
}

TEST(PoseGraph, CovarianceIsTrueOfWhatIsLeft) {
  double nees = 0;
  constexpr int kRuns = 800;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    Drive drive(seed, 4, 0.01, true);
    drive.graph.keep_only(thinned(drive.graph, false));
    const auto solution = drive.solve();
    const Vector3d error = newest_error(drive, solution);
    const Matrix3d covariance = solution.newest.covariance.topLeftCorner<3, 3>();
    nees += error.dot(covariance.inverse() * error) / kRuns;
  }
  EXPECT_GT(nees, 2.5);  // as in CovarianceIsTrue
  EXPECT_LT(nees, 3.6);
}

// Without revisits, extending the solution by a step equals solving again with that step.
TEST(PoseGraph, ExtendingIsSolving) {
  Drive drive(5, 2, 0.01, false);
  const PlanarEstimate before = drive.solve().newest;
  const PlanarStep step = step_of({{0.4, 0.1}, 0.3});
  drive.graph.add_node(step);
  const PlanarEstimate solved = drive.solve().newest;
  const PlanarEstimate extended = extend(before, step, drive.options.slip);
  EXPECT_LT((solved.pose.p - extended.pose.p).norm(), 1e-6);
  EXPECT_NEAR(solved.pose.yaw, extended.pose.yaw, 1e-7);
  EXPECT_LT((solved.covariance - extended.covariance).norm(), 1e-5 * solved.covariance.norm());
}

TEST(PoseGraph, RefusesWhatIsNoEdge) {
  PoseGraph graph(PlanarPose(), {});
  graph.add_node(step_of({{1, 0}, 0}));
  EXPECT_THROW(graph.add_revisit({0, 2}), std::invalid_argument);
  EXPECT_THROW(graph.add_revisit({1, 1}), std::invalid_argument);
  RevisitEdge exact{0, 1};
  exact.sigma_m = 0;
  EXPECT_THROW(graph.add_revisit(exact), std::invalid_argument);
  EXPECT_THROW(graph.keep_only({false, true}), std::invalid_argument);
  PlanarStep unknown = step_of({{1, 0}, 0});
  unknown.covariance.setZero();
  EXPECT_THROW(graph.add_node(unknown), std::invalid_argument);
}

}  // namespace
}  // namespace gprodom
