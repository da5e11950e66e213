#include "motion/slip_drift.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/lost_heading.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector2d;

constexpr ImuNoise kShaken{0.003, 0.12}, kQuiet{2e-4, 8e-4};  // densities, rad/s and m/s^2
constexpr int kStates = 400;                                  // five a second
constexpr double kSpeed = 0.4;                                // m/s

// Along x, then along y.
NavState state_at(int i) {
  NavState state;
  state.time = from_seconds(0.2 * i);
  const double way = 0.2 * kSpeed * i, leg = 0.1 * kSpeed * kStates;
  state.p_odom << std::min(way, leg), std::max(0.0, way - leg), 0.0;
  return state;
}

SlipDrift driven(const Config& config, const ImuNoise& noise) {
  SlipDrift drift(config);
  for (int i = 0; i <= kStates; ++i) drift.advance(state_at(i), noise, SlipModel().share);
  return drift;
}

TEST(SlipDrift, CovarianceIsThatOfSlipsDrawnFromTheModel) {
  const Config config;
  const SlipDrift drift = driven(config, kShaken);
  const SlipModel model = slip_model(config.wheel);
  const double kept = model.correlation(0.2), sigma = drift.sigma();
  Noise normal(3);
  Eigen::Matrix2d sampled = Eigen::Matrix2d::Zero();
  constexpr int kRuns = 4000;
  for (int run = 0; run < kRuns; ++run) {
    double l = sigma * normal();
    Vector2d error = Vector2d::Zero();
    for (int i = 1; i <= kStates; ++i) {
      l = kept * l + std::sqrt(1 - kept * kept) * sigma * normal();
      error += l * (state_at(i).p_odom - state_at(i - 1).p_odom).head<2>();
    }
    sampled += error * error.transpose() / kRuns;
  }
  EXPECT_LT((drift.covariance() - sampled).norm(), 0.08 * sampled.norm());
}

// What the online slip estimation leaves counts in the covariance, and not in the graph's weights.
TEST(SlipDrift, ASlipThatIsKnownBetterAddsLess) {
  const Config config;
  const SlipDrift without = driven(config, kShaken);
  const double ground = SlipModel().surface * SlipModel().surface;
  SlipDrift with(config);
  for (int i = 0; i <= kStates; ++i)
    with.advance(state_at(i), kShaken, SlipModel().share,
                 0.25 * without.sigma() * without.sigma() - ground);
  EXPECT_EQ(with.sigma(), without.sigma());
  // The first state's l has the prior's variance.
  EXPECT_GT(with.covariance().trace(), 0.25 * without.covariance().trace());
  EXPECT_LT(with.covariance().trace(), 0.5 * without.covariance().trace());
}

TEST(SlipDrift, AnImuThatCarriesTheSpeedIsAWitness) {
  const Config config;
  const double prior = slip_model(config.wheel).sigma();
  EXPECT_GT(driven(config, kShaken).sigma(), 0.8 * prior);
  EXPECT_LT(driven(config, kQuiet).sigma(), 0.3 * prior);
}

TEST(SlipDrift, NothingSlipsThatStandsOrHasNoWheel) {
  Config config;
  SlipDrift drift(config);
  NavState state;
  for (int i = 0; i < 50; ++i) {
    state.time = from_seconds(0.2 * i);
    drift.advance(state, kShaken, SlipModel().share);
  }
  EXPECT_EQ(drift.covariance().norm(), 0.0);
  config.wheel.slip_share = 0.0;
  EXPECT_EQ(driven(config, kShaken).covariance().norm(), 0.0);
  config = Config();
  config.wheel.enabled = false;
  EXPECT_EQ(driven(config, kShaken).sigma(), 0.0);
}

// The position is measured in one direction. The covariance there falls to that of the measurement,
// and across it falls as far as the slip is correlated.
TEST(SlipDrift, AMeasuredPlaceTellsOfPastSlip) {
  SlipDrift drift = driven(Config(), kShaken);
  const Eigen::Matrix2d before = drift.covariance();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  information(0, 0) = 1e4;
  drift.measure(information);
  EXPECT_NEAR(drift.covariance()(0, 0), 1 / (1 / before(0, 0) + 1e4), 1e-9);
  const double across = before(1, 1) - before(0, 1) * before(0, 1) / (before(0, 0) + 1e-4);
  EXPECT_NEAR(drift.covariance()(1, 1), across, 1e-6 * before(1, 1));
}

// As a passage of two antennas does, which is known only after it.
TEST(SlipDrift, ADistanceMeasuredAfterwardsTakesBackWhatSlipHadAdded) {
  SlipDrift drift{Config()};
  Eigen::Matrix2d then;
  for (int i = 0; i <= kStates; ++i) {
    drift.advance(state_at(i), kShaken, SlipModel().share);
    if (i == kStates - 50) then = drift.covariance();
  }
  ASSERT_GT(drift.covariance().trace(), 1.2 * then.trace());
  SlipDrift told = drift;
  drift.measured_since(state_at(kStates - 50).time, 1e3);  // nothing is known of the slip
  EXPECT_LT((drift.covariance() - then).norm(), 1e-6);
  drift.measured(state_at(kStates + 1), kShaken, SlipModel().share);
  EXPECT_LT((drift.covariance() - then).norm(), 1e-6);
  told.measured_since(state_at(kStates - 50).time, 0.01);
  EXPECT_LT(told.covariance().trace(), 0.99 * then.trace()) << "slip before was much the same";
}

// The covariance of a position whose heading is hardly known.
// Thirty metres along x, then forty along y, all with the same error of the heading.
TEST(LostHeading, WithTheLinearPartItIsTheSecondMomentOfHeadingsDrawn) {
  for (const double sigma : {0.1, 0.5, 1.5}) {
    LostHeading heading;
    NavState state;
    for (int i = 0; i <= 70; ++i) {
      state.p_odom << std::min(i, 30), std::max(i - 30, 0), 0.0;
      heading.advance(state, sigma * sigma);
    }
    const Vector2d way(30.0, 40.0), ahead = way.normalized(), aside(-ahead.y(), ahead.x());
    Noise normal(1);
    double along = 0.0;
    constexpr int kRuns = 20000;
    for (int run = 0; run < kRuns; ++run) {
      const double d = sigma * normal();
      const Vector2d true_way = std::cos(d) * way + std::sin(d) * way.norm() * aside;
      along += std::pow((true_way - way).dot(ahead), 2) / kRuns;
    }
    const Eigen::Matrix2d covariance = heading.covariance();
    EXPECT_NEAR(std::sqrt(ahead.dot(covariance * ahead)), std::sqrt(along), 0.05 * std::sqrt(along))
        << sigma;
    EXPECT_NEAR(aside.dot(covariance * aside), 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace gprodom
