#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "estimation/factors.h"
#include "estimation/graph/planar_factors.h"
#include "estimation/graph/pose_graph.h"
#include "estimation/graph/robust_kernels.h"
#include "estimation/planar_steps.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStep = 0.5;     // m between nodes, as the wheel has it
constexpr double kSeconds = 1.5;  // that a step takes
constexpr int kLap = 40;          // steps
constexpr double kNoise = 0.01;   // m, rad; of a step of noisy odometry

// Laps of a square. The odometry reads e^-l times the true distance, with l the slip of each step.
// If `tied`, each step from the second lap on ends at a revisit, whose older end lies on the step
// from the node of the lap before, at this share of it. With `noise`, the odometry and the revisits
// have errors.
struct Laps {
  std::vector<PlanarPose> truth{PlanarPose()};
  PoseGraph graph;

  Laps(const std::vector<double>& slip, bool tied, double slip_sigma, const SlipModel& model = {},
       double beyond = 0.0, std::mt19937* noise = nullptr)
      : graph({}, options_with(model)) {
    std::normal_distribution<double> normal;
    for (std::size_t i = 0; i < slip.size(); ++i) {
      const bool corner = i % (kLap / 4) == kLap / 4 - 1;
      const PlanarPose step{{kStep, 0.0}, corner ? M_PI / 2 : 0.0};
      truth.push_back(compose(truth.back(), step));
      PlanarStep seen = step_of({std::exp(-slip[i]) * step.p, step.yaw}, {1e-5, 1e-5, 1e-8});
      if (noise) {
        seen.covariance = 0.01 * kNoise * kNoise * Eigen::Matrix3d::Identity();
        seen.measured.p += kNoise * Vector2d(normal(*noise), normal(*noise));
        seen.measured.yaw += kNoise * normal(*noise);
      }
      seen.seconds = kSeconds;
      seen.slip_sigma = slip_sigma;
      const std::size_t node = graph.add_node(seen);
      if (!tied || node <= kLap) continue;
      RevisitEdge edge{node - kLap, node};
      edge.sigma_m = 0.02;
      if (noise) edge.offset_m = edge.sigma_m * normal(*noise);
      if (beyond > 0.0 && i + 1 < slip.size()) {
        edge.memory_way.p.x() = kStep * beyond * std::exp(-slip[node - kLap]);
        edge.query_way.p.x() = kStep * beyond * std::exp(-slip[node]);
        edge.memory_at.p = edge.memory_way.p;
        edge.query_at.p = edge.query_way.p;
      }
      graph.add_revisit(edge);
    }
  }

  static PoseGraphOptions options_with(const SlipModel& model) {
    PoseGraphOptions options;
    options.slip = model;
    return options;
  }

  // Largest distance of two nodes, over that of the truth.
  double size(const PoseGraphSolution& solution) const {
    const auto extent = [](const std::vector<PlanarPose>& nodes) {
      double most = 0.0;
      for (const PlanarPose& node : nodes) most = std::max(most, (node.p - nodes.back().p).norm());
      return most;
    };
    return extent(solution.nodes) / extent(truth);
  }

  double error(const PoseGraphSolution& solution) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += (solution.nodes[i].p - truth[i].p).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }
};

// No slip, except for one in the second lap that lasts ten steps.
std::vector<double> one_slip(double size, int laps) {
  std::vector<double> slip(static_cast<std::size_t>(laps * kLap), 0.0);
  for (std::size_t i = kLap + 5; i < kLap + 15; ++i) slip[i] = size;
  return slip;
}

// Laps do not show how large they are. If a smaller track had smaller errors, the graph would
// shrink.
TEST(SlipOfSteps, ASmallerTrackHasTheSameErrors) {
  PlanarStep step;
  step.measured = {{0.5, 0.02}, 0.1};
  Eigen::Matrix3d whitening = Vector3d(100.0, 80.0, 300.0).asDiagonal();
  whitening(2, 0) = 20.0;
  const auto errors = [&](double l) {
    const PlanarPose to = {{0.53 * std::exp(l), 0.01 * std::exp(l)}, 0.12};
    return step_residual({step, whitening}, {}, to, 1.0, l).value;
  };
  EXPECT_LT((errors(-0.7) - errors(0.0)).norm(), 1e-12 * errors(0.0).norm());
}

TEST(SlipOfSteps, KernelsWeighByTheirOwnDerivatives) {
  for (const auto kernel : {cauchy, geman_mcclure, huber}) {
    for (const double width : {1.5, 12.0}) {
      for (const double s : {0.1, 2.0, 50.0}) {
        const double h = 1e-5;
        const double slope = (kernel(s + h, width).cost - kernel(s - h, width).cost) / (2 * h);
        EXPECT_NEAR(slope, kernel(s, width).weight, 1e-6);
      }
    }
  }
}

// The slip in the second lap contradicts the first and the third lap, which agree. The graph must
// find it where it was, and leave the laps without slip unchanged.
TEST(SlipOfSteps, RevisitsFindWhereTheWheelSlipped) {
  for (const double size : {-0.1, -0.5, 0.1}) {
    Laps laps(one_slip(size, 3), true, SlipModel().sigma());
    const PoseGraphSolution solution = laps.graph.solve(1.0, 0.02);
    EXPECT_LT(laps.error(solution), 0.05) << size;
    EXPECT_NEAR(laps.graph.slip(kLap + 10), size, 0.03) << size;
    EXPECT_NEAR(laps.graph.slip(kLap / 2), 0.0, 0.01) << size;
    EXPECT_NEAR(laps.graph.slip(2 * kLap + kLap / 2), 0.0, 0.01) << size;
    for (const bool trusted : solution.trusted) EXPECT_TRUE(trusted);
  }
}

// Where the places of a revisit lie between nodes, the slip stretches the way to them too.
TEST(SlipOfSteps, PlacesBetweenNodesLieWhereTheSlipPutsThem) {
  Laps laps(one_slip(-0.5, 3), true, SlipModel().sigma(), {}, 0.5);
  const PoseGraphSolution solution = laps.graph.solve(1.0, 0.02);
  EXPECT_LT(laps.error(solution), 0.02);
  const PlanarPose half = {{0.5 * kStep * std::exp(0.5), 0.0}, 0.0};
  const PlanarPose place = laps.graph.place(kLap + 10, half, {half.p, false});
  EXPECT_NEAR((place.p - laps.truth[kLap + 10].p).norm(), 0.5 * kStep, 0.01);
}

// The errors are larger than the odometry's covariance says, and would fit together if the laps
// were smaller.
TEST(SlipOfSteps, LapsAreNotMadeSmallerToFitTogether) {
  std::mt19937 engine(7);
  for (int run = 0; run < 5; ++run) {
    Laps laps(one_slip(-0.2, 8), true, SlipModel().sigma(), {}, 0.0, &engine);
    EXPECT_NEAR(laps.size(laps.graph.solve(1.0, 0.02)), 1.0, 0.25) << run;
  }
}

// The wheel slips at the newest revisit, and no ground is known beyond. The slip has ended, sooner
// or later: a minute on, later solutions must not go on with it.
TEST(SlipOfSteps, ASlipEndsWhereNothingIsKnown) {
  constexpr double kSigma = 0.1;  // of slip, as far as the IMU tells
  std::vector<double> slip = one_slip(-0.17, 2);
  slip.resize(kLap + 15);
  Laps laps(slip, false, kSigma);
  for (std::size_t node = kLap + 1; node <= kLap + 15; ++node) {
    RevisitEdge edge{node - kLap, node};
    edge.sigma_m = 0.02;
    laps.graph.add_revisit(edge);
  }
  laps.graph.solve(1.0, 0.0);
  EXPECT_NEAR(laps.graph.slip(kLap + 14), -0.17, 0.05);
  PlanarStep straight = step_of({{kStep, 0.0}, 0.0}, {1e-5, 1e-5, 1e-8});
  straight.seconds = 0.25;
  straight.slip_sigma = kSigma;
  for (int i = 0; i < 240; ++i) {
    laps.graph.add_node(straight);
    laps.truth.push_back(compose(laps.truth.back(), straight.measured));
    laps.graph.solve(1.0, 0.0);
  }
  const PoseGraphSolution solution = laps.graph.solve(1.0, 0.0);
  EXPECT_NEAR(solution.newest.slip, -0.17 * std::exp(-60.0 / 20.0), 0.01);
  // By its mean the slip lasts 20 s, in which 40 m are driven.
  EXPECT_LT((solution.nodes.back().p - laps.truth.back().p).norm(), 0.17 * 40.0 + 0.3);
}

// Slips drawn from the model, small enough to be linear in, and nothing that sees them: the
// covariance of the place holds.
TEST(SlipOfSteps, CovarianceHoldsWhereNoWitnessSpeaks) {
  SlipModel model;
  model.size = 0.1;
  Noise normal(4);
  double nees = 0.0;
  constexpr int kRuns = 300;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> slip;
    double l = model.sigma() * normal();
    const double kept = model.correlation(kSeconds);
    for (int i = 0; i < kLap - 10; ++i) {
      if (i > 0) l = kept * l + std::sqrt(1 - kept * kept) * model.sigma() * normal();
      slip.push_back(l);
    }
    Laps laps(slip, false, model.sigma(), model);
    const PlanarEstimate newest = laps.graph.solve(1.0, 0.0).newest;
    const Vector2d error = newest.pose.p - laps.truth.back().p;
    nees += error.dot(newest.covariance.topLeftCorner<2, 2>().inverse() * error) / kRuns;
  }
  EXPECT_GT(nees, 1.2);  // two degrees of freedom; what l is not linear in is left out
  EXPECT_LT(nees, 2.8);
}

}  // namespace
}  // namespace gprodom
