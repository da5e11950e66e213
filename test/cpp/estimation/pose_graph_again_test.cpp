// The pose graph solved again and again while it grows: what a solution costs, in iterations, and
// what becomes of revisits that an earlier one has left out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimation/graph/planar_factors.h"
#include "estimation/graph/pose_graph.h"
#include "estimation/planar_steps.h"
#include "support/derivative.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr std::size_t kRound = 80;  // nodes
constexpr double kStep = 0.5;       // m

// A circle driven again and again with noise; from the second round on, every fourth node is a
// revisit of the first round.
class Rounds {
 public:
  PoseGraph graph{PlanarPose(), {}};

  explicit Rounds(std::size_t nodes) { drive(nodes); }

  void drive(std::size_t nodes) {
    for (std::size_t i = 0; i < nodes; ++i) {
      const double x = kStep + 0.005 * normal_(), y = 0.003 * normal_();
      const double yaw = 2 * M_PI / kRound + 0.002 * normal_();
      const std::size_t node = graph.add_node(step_of({{x, y}, yaw}, {2.5e-5, 9e-6, 4e-6}));
      if (node > kRound && node % 4 == 0) revisit(node % kRound, node, 0.0);
    }
  }

  // wrong_m: how far off; such a one takes no noise, so that it leaves that of the others as it is.
  void revisit(std::size_t memory, std::size_t query, double wrong_m) {
    RevisitEdge edge{memory, query};
    edge.offset_m = wrong_m != 0.0 ? wrong_m : edge.sigma_m * normal_();
    edge.lateral_m = wrong_m != 0.0 ? 0.0 : 0.5 * edge.lateral_sigma_m * normal_();
    graph.add_revisit(edge);
  }

  PoseGraphSolution solve() { return graph.solve(1.0, 0.01); }

 private:
  Noise normal_{5};
};

// That it is left out has been found out once, with wide kernels, which lead far from the last
// solution and back.
TEST(PoseGraphAgain, ARevisitThatWasLeftOutCostsNoMoreIterations) {
  Rounds rounds(2 * kRound), clean(2 * kRound);
  rounds.solve();
  clean.solve();
  const std::size_t wrong = rounds.graph.revisits().size();
  rounds.revisit(kRound / 2, 2 * kRound - 10, 3.0);
  rounds.solve();
  int iterations = 0, without_it = 0;
  for (int more = 0; more < 10; ++more) {
    rounds.drive(4);
    clean.drive(4);
    const auto solution = rounds.solve(), without = clean.solve();
    EXPECT_FALSE(solution.trusted[wrong]);
    EXPECT_EQ(std::count(solution.trusted.begin(), solution.trusted.end(), false), 1);
    iterations += solution.iterations;
    without_it += without.iterations;
  }
  // Once in these rounds a right one lies so far from dead reckoning that all are tried.
  EXPECT_LT(iterations, 1.5 * without_it);
}

// Wrong revisits that were left out are not tried again because a right one lies far from dead
// reckoning.
TEST(PoseGraphAgain, WhatNothingContradictsIsSolvedInAFewIterations) {
  Rounds rounds(2 * kRound);
  for (std::size_t i = 0; i < 3; ++i) rounds.revisit(20 + 9 * i, 2 * kRound - 10 - 5 * i, 1.0);
  rounds.solve();
  int iterations = 0;
  for (int more = 0; more < 20; ++more) {
    rounds.drive(4);
    const auto solution = rounds.solve();
    EXPECT_EQ(std::count(solution.trusted.begin(), solution.trusted.end(), false), 3);
    iterations += solution.iterations;
  }
  EXPECT_LT(iterations, 20 * 5);
}

// Many short solutions lead to where one over all leads.
TEST(PoseGraphAgain, GoingOnFromTheLastSolutionEqualsSolvingAtOnce) {
  Rounds step_by_step(kRound), at_once(kRound);
  for (int more = 0; more < 20; ++more) {
    step_by_step.drive(8);
    step_by_step.solve();
  }
  at_once.drive(20 * 8);
  const auto one = step_by_step.solve(), other = at_once.solve();
  EXPECT_EQ(one.trusted, other.trusted);
  const double sigma = std::sqrt(other.newest.covariance(0, 0));
  EXPECT_LT((one.newest.pose.p - other.newest.pose.p).norm(), 0.1 * sigma);
}

// It is tried again when others that agree with it contradict the solution.
TEST(PoseGraphAgain, ARevisitThatWasLeftOutIsTrustedWhenOthersProveIt) {
  Rounds rounds(kRound + 20);  // the last nodes have right revisits
  const std::size_t right = rounds.graph.revisits().size();
  for (int i = 0; i < 12; ++i) rounds.revisit(20 + static_cast<std::size_t>(i), kRound + 20, -3.0);
  EXPECT_GT(right, 3U);
  rounds.solve();
  rounds.drive(kRound);
  const auto solution = rounds.solve();
  for (std::size_t i = 0; i < right; ++i) EXPECT_TRUE(solution.trusted[i]) << i;
}

// Removed nodes take their revisits with them, and what is left keeps its judgement.
TEST(PoseGraphAgain, WhatWasLeftOutStaysSoWhenNodesGo) {
  Rounds rounds(2 * kRound);
  rounds.revisit(kRound / 2, 2 * kRound - 10, 3.0);
  EXPECT_FALSE(rounds.solve().trusted.back());
  std::vector<bool> stay(rounds.graph.nodes().size(), true);
  for (std::size_t i = kRound + 1; i < kRound + 30; ++i) stay[i] = false;
  rounds.graph.keep_only(stay);
  const auto solution = rounds.solve();
  EXPECT_FALSE(solution.trusted.back());
  EXPECT_EQ(std::count(solution.trusted.begin(), solution.trusted.end(), false), 1);
  EXPECT_LE(solution.iterations, 10);
}

TEST(PoseGraphAgain, APieceThatNothingTiesStaysWhereItWas) {
  Rounds rounds(2 * kRound);
  const std::size_t between = rounds.graph.revisits().back().query + 1;
  rounds.drive(4);
  std::vector<bool> cut(rounds.graph.nodes().size());
  cut[between] = cut[between + 1] = true;
  rounds.graph.keep_only(std::vector<bool>(cut.size(), true), cut);
  const PlanarPose before = rounds.graph.nodes()[between];
  EXPECT_LT((rounds.solve().nodes[between].p - before.p).norm(), 1e-6);
}

// Steps as sure as those of a robot that hardly moves, and a long piece that hardly anything holds:
// rounding must not make a variance negative.
TEST(PoseGraphAgain, CovarianceOfALoosePieceIsPositive) {
  PoseGraph graph(PlanarPose(), {});
  for (int i = 0; i < 4000; ++i)
    graph.add_node(step_of({{1e-3, 0.0}, 1e-3}, {1e-14, 1e-14, 1e-14}));
  std::vector<bool> cut(graph.nodes().size());
  cut[10] = true;
  graph.keep_only(std::vector<bool>(cut.size(), true), cut);
  const PoseGraphSolution solution = graph.solve(1.0, 0.0);
  for (int k = 0; k < 3; ++k) EXPECT_GT(solution.newest.covariance(k, k), 0.0);
}

// Half a round since the last solution, whose error is that of dead reckoning. The newest nodes
// alone come to lie as all of them would, at a small part of the work.
TEST(PoseGraphAgain, TheNewestNodesAreCorrectedBetweenSolutions) {
  Rounds rounds(10 * kRound), whole(10 * kRound);
  const auto before = rounds.solve();
  whole.solve();
  const std::size_t from = rounds.graph.nodes().size() - 1;
  rounds.drive(kRound / 2);
  whole.drive(kRound / 2);
  const PlanarPose reckoned = rounds.graph.nodes().back();
  const auto newest =
      rounds.graph.solve_newest(from, before.newest.covariance.topLeftCorner<3, 3>());
  const auto all = whole.solve();
  ASSERT_TRUE(newest);
  const double off_m = (reckoned.p - all.newest.pose.p).norm();
  EXPECT_GT(off_m, 0.03);
  EXPECT_LT((newest->newest.p - all.newest.pose.p).norm(), 0.3 * off_m);
  EXPECT_LT(newest->work, 0.1 * all.work);
  EXPECT_EQ(newest->trusted.size(), 10U);
  EXPECT_EQ(newest->trusted.back(), rounds.graph.revisits().size() - 1);
  EXPECT_EQ(rounds.graph.nodes()[from].p, before.nodes[from].p);
  EXPECT_EQ(rounds.graph.nodes().back().p, newest->newest.p);
}

TEST(PoseGraphAgain, NodesWithoutARevisitStayWhereTheyAre) {
  Rounds rounds(2 * kRound);
  const auto before = rounds.solve();
  const std::size_t from = rounds.graph.nodes().size() - 1;
  rounds.drive(2);
  const PlanarPose reckoned = rounds.graph.nodes().back();
  EXPECT_FALSE(rounds.graph.solve_newest(from, before.newest.covariance.topLeftCorner<3, 3>()));
  EXPECT_EQ(rounds.graph.nodes().back().p, reckoned.p);
}

// Fixes as edges of the pose graph.
using Eigen::Vector3d;

// A fix's residual against differences of itself.
TEST(PoseGraph, FixDerivatives) {
  FixEdge fix;
  fix.at = {{0.4, -0.7}, 0.3};
  fix.way = {{0.3, 0.1}, false};
  fix.p = {1.0, 2.0};
  fix.covariance << 0.04, 0.01, 0.01, 0.09;
  const PlanarPose node{{0.5, 1.5}, 0.8};
  const FixResidual found(fix, node, 0.1);
  const Eigen::MatrixXd numeric = numeric_jacobian(4, 1e-3, [&](const Eigen::Vector4d& d) {
    return FixResidual(fix, {node.p + d.head<2>(), node.yaw + d[2]}, 0.1 + d[3]).value;
  });
  EXPECT_LT((numeric - found.J).norm(), 1e-7) << numeric;
}

// Two fixes far from each other: the wheel's scale, and the track in their frame.
TEST(PoseGraph, FixesAtBothEndsGiveTheScale) {
  constexpr double kLength = 90.0, kSigma = 0.02;
  PoseGraph graph(PlanarPose(), {});
  // The wheel reports 2 % too much.
  const PlanarStep step = step_of({{1.02 * kStep, 0.0}, 0.0}, {1e-6, 1e-6, 1e-8});
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
  graph.add_node(step_of({{kStep, 0.0}, 0.0}, {1e-10, 1e-10, 1e-12}));
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
