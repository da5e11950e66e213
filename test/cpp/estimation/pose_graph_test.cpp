#include "estimation/graph/pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "estimation/graph/planar_factors.h"
#include "estimation/planar_steps.h"
#include "support/derivative.h"
#include "support/noise.h"

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
  // yaw_sigma: loose, since the places of this drive are exact and would falsify the statistics.
  Drive(unsigned seed, int passes, double scale_sigma, bool with_revisits, double yaw_sigma = 10);
};

Drive::Drive(unsigned seed, int passes, double sigma, bool with_revisits, double yaw_sigma)
    : options([&] {
        PoseGraphOptions o;
        o.revisit_yaw_sigma = yaw_sigma;
        return o;
      }()),
      scale_sigma(sigma),
      truth{PlanarPose()},
      graph(PlanarPose(), options) {
  Noise normal(seed);
  const double scale_error = scale_sigma * normal();
  auto go = [&](const PlanarPose& step) {
    truth.push_back(compose(truth.back(), step));
    PlanarPose seen = step;
    seen.p *= 1 + scale_error;
    const Vector3d sigma = step_of(step).covariance.diagonal().cwiseSqrt();
    seen.p.x() += sigma[0] * normal();
    seen.p.y() += sigma[1] * normal();
    seen.yaw += sigma[2] * normal();
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
      edge.offset_m = there.p.x() + edge.sigma_m * normal();
      edge.lateral_m = there.p.y() + edge.lateral_sigma_m * normal();
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

// Squared error over its covariance.
double nees(const Drive& drive, const PoseGraphSolution& solution) {
  const Vector3d error = newest_error(drive, solution);
  return error.dot(solution.newest.covariance.topLeftCorner<3, 3>().inverse() * error);
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
    const Eigen::MatrixXd numeric = numeric_jacobian(
        8, 1e-3, [&](const Unknowns& d) { return residual(at + d, revisit).value; });
    const Eigen::ArrayXXd off = numeric - Eigen::MatrixXd(analytic.J);
    EXPECT_LT((off.abs() / (1 + numeric.array().abs())).maxCoeff(), 1e-6)
        << (revisit ? "revisit" : "step") << "\n"
        << off;
  }
  const FirstPrior prior{{{0.3, -0.4}, 3.1}, step.whitening};
  const PlanarPose at{{1.2, 0.7}, -3.0};
  const Eigen::MatrixXd of_prior = numeric_jacobian(3, 1e-3, [&](const Vector3d& d) {
    return prior_residual(prior, {at.p + d.head<2>(), at.yaw + d[2]});
  });
  EXPECT_LT((of_prior - prior.whitening).norm(), 1e-6) << of_prior;
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

// One that says nothing wrong along the track, but is ten standard deviations off otherwise.
TEST(PoseGraph, RevisitsThatAreOffSidewaysOrInYawAreLeftOut) {
  for (const bool in_yaw : {false, true}) {
    Drive drive(3, 4, 0.01, true, in_yaw ? 0.2 : 10.0);
    const auto clean = drive.solve();
    const std::size_t honest = drive.graph.revisits().size();
    RevisitEdge wrong{10, 91};  // driven the same way
    const PlanarPose there = between(drive.truth[10], drive.truth[91]);
    wrong.offset_m = there.p.x();
    wrong.lateral_m = there.p.y() + (in_yaw ? 0.0 : 10 * wrong.lateral_sigma_m);
    if (in_yaw) wrong.query_at.yaw = 10 * drive.options.revisit_yaw_sigma;
    drive.graph.add_revisit(wrong);
    const auto solution = drive.solve();
    EXPECT_FALSE(solution.trusted[honest]) << "in yaw: " << in_yaw;
    for (std::size_t i = 0; i < honest; ++i) EXPECT_TRUE(solution.trusted[i]);
    for (std::size_t i = 0; i < clean.nodes.size(); ++i)
      EXPECT_LT((solution.nodes[i].p - clean.nodes[i].p).norm(), 1e-3) << i;
  }
}

// What a revisit that is just not left out may do to the solution: no more than a right one.
TEST(PoseGraph, ARevisitThatIsNearlyLeftOutPullsNoHarderThanARightOne) {
  const auto moved_by =
      [](double deviation) {  // of the line's end, by a revisit that is so far off
        PoseGraph graph(PlanarPose(), {});
        for (int i = 0; i < 10; ++i) graph.add_node(step_of({{kStep, 0}, 0}));
        RevisitEdge right{0, 10}, off{0, 10};
        right.offset_m = off.offset_m = 10 * kStep;
        right.sigma_m = 0.001;  // keeps the line where it is
        off.sigma_m = 0.1;
        off.offset_m += deviation * off.sigma_m;
        graph.add_revisit(right);
        graph.add_revisit(off);
        const auto solution = graph.solve(1.0, 0.0);
        EXPECT_TRUE(solution.trusted[1]);
        return solution.nodes.back().p.x() - 10 * kStep;
      };
  const double full = moved_by(PoseGraphOptions().full_weight_below);
  EXPECT_NEAR(moved_by(1.0), full / PoseGraphOptions().full_weight_below, 1e-2 * full);
  EXPECT_NEAR(moved_by(4.6), full, 1e-2 * full);
}

// A track that goes on in the map of an earlier run, known to sigma (m, and a twentieth of it in
// rad). It is driven there and back, with revisits of its own.
struct Resumed {
  Drive drive;
  Resumed(unsigned seed, double sigma) : drive(seed, 2, 0.01, true) {
    drive.graph.set_first_prior(prior(sigma));
  }
  static Matrix3d prior(double sigma) {
    return Vector3d(sigma, sigma, 0.05 * sigma).cwiseAbs2().asDiagonal();
  }
  // A revisit at a node on ground of the earlier run, `off` m wrong.
  void see_earlier_ground(std::size_t node, double off) {
    RevisitEdge edge{kInMap, node, drive.truth[node]};
    edge.offset_m = off;
    drive.graph.add_revisit(edge);
  }
};

double position_sigma(const PoseGraphSolution& solution) {
  return std::sqrt(solution.newest.covariance.topLeftCorner<2, 2>().trace() / 2);
}

TEST(ResumedTrack, ARightRevisitOfEarlierGroundAloneTellsWhereItIs) {
  Resumed unsure(5, 1.0), without(5, 0.1);
  EXPECT_GE(position_sigma(unsure.drive.solve()), 1.0) << "by its own revisits";
  const auto before = without.drive.solve();
  for (const double off : {0.05, 3.0}) {
    Resumed resumed(5, 0.1);
    resumed.see_earlier_ground(30, off);
    const auto solution = resumed.drive.solve();
    EXPECT_EQ(solution.trusted.back(), off < 1);
    EXPECT_EQ(position_sigma(solution) < 0.999 * position_sigma(before), off < 1);
    if (off > 1) {
      EXPECT_LT((solution.nodes.back().p - before.nodes.back().p).norm(), 0.01);
    }
  }
}

TEST(ResumedTrack, ItsCovarianceIsTrue) {
  Noise normal(1);
  double mean = 0;
  constexpr int kRuns = 400;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    Resumed resumed(seed, 0.2);
    const Matrix3d prior = Resumed::prior(0.2);
    // The truth is where the prior lets it be.
    const PlanarPose start{{std::sqrt(prior(0, 0)) * normal(), std::sqrt(prior(1, 1)) * normal()},
                           std::sqrt(prior(2, 2)) * normal()};
    for (PlanarPose& pose : resumed.drive.truth) pose = compose(start, pose);
    if (seed % 2 == 1) {  // every second one sees earlier ground
      for (const std::size_t node : {20, 30})
        resumed.see_earlier_ground(node, RevisitEdge().sigma_m * normal());
    }
    mean += nees(resumed.drive, resumed.drive.solve()) / kRuns;
  }
  // Chi-square of 1200 degrees of freedom over 400: 99 % within 2.69 to 3.32. The kernels lose a
  // little of the information, and lateral offsets here have no error.
  EXPECT_GT(mean, 2.5);
  EXPECT_LT(mean, 3.4);
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

// A slip between distances that were measured whatever the wheel did is not one of all of them.
TEST(PoseGraph, ASlipBesideAMeasuredDistanceIsAnErrorOfTheJoinedStep) {
  const PlanarStep measured = step_of({{0.5, 0.0}, 0.0});
  PlanarStep slips = measured;
  slips.slip_sigma = 0.2;
  const double known = joined(measured, measured).covariance(0, 0);
  for (const PlanarStep& both : {joined(measured, slips), joined(slips, measured)}) {
    EXPECT_EQ(both.slip_sigma, 0.0);
    EXPECT_NEAR(both.covariance(0, 0) - known, 0.01, 1e-9);  // (0.2 * 0.5 m)^2
  }
  EXPECT_EQ(joined(slips, slips).slip_sigma, 0.2);
  EXPECT_NEAR(joined(slips, slips).covariance(0, 0), known, 1e-9);
}

// Also of what is left when nodes have gone, and of pieces between cuts.
TEST(PoseGraph, CovarianceIsTrue) {
  struct Case {
    bool with_revisits, thins, cuts;
  };
  for (const auto& [with_revisits, thins, cuts] :
       {Case{false, false, false}, Case{true, false, false}, Case{true, true, false},
        Case{true, true, true}}) {
    double mean = 0;
    constexpr int kRuns = 800;
    for (unsigned seed = 0; seed < kRuns; ++seed) {
      Drive drive(seed, thins ? 4 : 3, 0.01, with_revisits);
      const std::vector<RevisitEdge>& revisits = drive.graph.revisits();
      std::vector<bool> cut(drive.graph.nodes().size());
      for (std::size_t i = 2; cuts && i < revisits.size(); i += 4) cut[revisits[i].query] = true;
      if (thins) drive.graph.keep_only(thinned(drive.graph, cuts), cut);
      mean += nees(drive, drive.solve()) / kRuns;
    }
    // Chi-square of 600 degrees of freedom over 200: 99 % within 2.57 to 3.46. A robust kernel
    // loses a little of the information.
    EXPECT_GT(mean, 2.5) << with_revisits << thins << cuts;
    EXPECT_LT(mean, 3.6) << with_revisits << thins << cuts;
  }
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
