#include "gpr/sequential/sfm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace gprodom::gpr {
namespace {

TEST(Sfm, CellsAndLevelsAreThoseOfTheEquations) {
  std::mt19937 random(3);
  const SfmGrid grid{7, 11, 4.0, 100.0, 50.0};
  std::uniform_real_distribution<double> depth(0.0, 4.0), position(0.0, 100.0),
      amplitude(0.0, 80.0);
  std::vector<FeaturePoint> points;
  for (int i = 0; i < 60; ++i) {
    points.push_back({depth(random), position(random), amplitude(random)});
  }
  LevelMatrix levels;
  build_sfm(points.data(), points.size(), grid, levels);

  // The other way round: each cell looks for the points within its borders.
  int collisions = 0;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      int expected = 0, inside = 0;
      for (const FeaturePoint& p : points) {
        const double d = p.depth / 4.0 * 7 - row, r = p.position / 100.0 * 11 - column;
        if (d < 0 || d >= 1 || r < 0 || r >= 1) continue;
        ++inside;
        int level = 0;
        while (level < 10 && p.amplitude / 50.0 * 10.0 >= level + 1) ++level;
        expected = std::max(expected, level);
      }
      collisions += inside > 1 ? 1 : 0;
      EXPECT_EQ(levels(row, column), expected) << row << "," << column;
    }
  }
  EXPECT_GT(collisions, 5);  // or the rule for them went untested
}

TEST(Sfm, BordersAreClampedAndBadPointsLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SfmGrid grid{4, 5, 2.0, 10.0, 1.0};
  const FeaturePoint points[] = {{-0.1, 3.0, 0.5}, {2.0, 10.0, 9.0}, {nan, 1.0, 1.0},
                                 {1.0, nan, 1.0},  {1.0, 1.0, nan},  {1.0, 1.0, -1.0}};
  LevelMatrix levels, expected = LevelMatrix::Zero(4, 5);
  expected(0, 1) = 5;
  expected(3, 4) = 10;
  build_sfm(points, 6, grid, levels);
  EXPECT_EQ(levels, expected);
  EXPECT_THROW(build_sfm(points, 6, {0, 5, 2.0, 10.0, 1.0}, levels), std::invalid_argument);
  EXPECT_THROW(build_sfm(points, 6, {4, 5, 2.0, 10.0, 0.0}, levels), std::invalid_argument);
}

TEST(Sfm, LevelsChangeAtTenthsOfTheFullPixel) {
  EXPECT_EQ(feature_level(25.49), 0);
  EXPECT_EQ(feature_level(25.5), 1);
  EXPECT_EQ(feature_level(254.99), 9);
  EXPECT_EQ(feature_level(255.0), 10);
}

TEST(AmplitudeScale, IsTheQuantileOfWhatWasSeenAndThenStays) {
  AmplitudeScale scale(0.5);
  EXPECT_FALSE(scale.fix());
  for (const double a : {5.0, 1.0, 3.0, -7.0, 1e9}) scale.collect(a);
  EXPECT_FALSE(scale.value());
  ASSERT_TRUE(scale.fix());
  EXPECT_EQ(*scale.value(), 3.0);
  scale.collect(100.0);
  EXPECT_TRUE(scale.fix());
  EXPECT_EQ(*scale.value(), 3.0);
}

}  // namespace
}  // namespace gprodom::gpr
