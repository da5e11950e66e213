// The covariance of a position whose heading is hardly known.
#include "motion/lost_heading.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector2d;

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
