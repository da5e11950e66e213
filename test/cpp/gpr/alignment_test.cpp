#include "gpr/sequential/alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "gpr/sequential/sfm.h"

namespace gprodom::gpr {
namespace {

LevelMatrix random_levels(int rows, int columns, std::mt19937& random) {
  std::uniform_int_distribution<int> level(-20, kMaxFeatureLevel);  // most cells are empty
  return LevelMatrix::NullaryExpr(
      rows, columns, [&] { return static_cast<std::int8_t>(std::max(0, level(random))); });
}

// The equation as it stands, cell by cell.
double plain_distance(const LevelMatrix& a, const LevelMatrix& b, int shift, DistanceForm form) {
  double ab = 0, aa = 0, bb = 0;
  for (int r = 0; r < a.rows(); ++r) {
    for (int c = 0; c < a.cols(); ++c) {
      if (c + shift < 0 || c + shift >= b.cols()) continue;
      ab += a(r, c) * b(r, c + shift);
      aa += a(r, c) * a(r, c);
      bb += b(r, c + shift) * b(r, c + shift);
    }
  }
  return 1.0 - ab / (form == DistanceForm::kCosine ? std::sqrt(aa * bb) : aa * bb);
}

TEST(Alignment, DistancesAreThoseOfTheEquationForEveryShift) {
  std::mt19937 random(5);
  for (const auto form : {DistanceForm::kCosine, DistanceForm::kPrinted}) {
    for (const auto& [rows, columns] : {std::pair{50, 50}, {7, 13}, {1, 3}}) {
      const LevelMatrix a = random_levels(rows, columns, random);
      const LevelMatrix b = random_levels(rows, columns, random);
      Aligner aligner({form, 0.3, 0}), real({form, 0.3, 0});
      aligner.align(a, b);
      real.align(Eigen::MatrixXf(a.cast<float>()), Eigen::MatrixXf(b.cast<float>()));
      const ShiftDistances& got = aligner.distances();
      ASSERT_EQ(got.limit, columns - static_cast<int>(std::ceil(0.3 * columns)));
      for (int shift = -got.limit; shift <= got.limit; ++shift) {
        const double expected = plain_distance(a, b, shift, form);
        if (std::isnan(got.at(shift))) {
          EXPECT_FALSE(std::isfinite(expected));
          continue;
        }
        EXPECT_NEAR(got.at(shift), expected, 1e-12);
        EXPECT_NEAR(real.distances().at(shift), expected, 1e-6);
      }
    }
  }
}

TEST(Alignment, TracesThatEnterOnTheRightGiveANegativeShift) {
  std::mt19937 random(6);
  const LevelMatrix ground = random_levels(50, 80, random);
  for (const int entered : {0, 1, 5, 29}) {
    const Alignment alignment = Aligner().align(LevelMatrix(ground.leftCols(50)),
                                                LevelMatrix(ground.middleCols(entered, 50)));
    EXPECT_TRUE(alignment.valid);
    EXPECT_EQ(alignment.shift, -entered);
    EXPECT_EQ(alignment.overlap, 50 - entered);
    EXPECT_NEAR(alignment.distance, 0.0, 1e-12);
  }
}

// Where everything has some energy the sums of the printed form fall with the overlap and the true
// place does not show.
TEST(Alignment, ThePrintedFormRunsToTheSearchLimit) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> level(0, kMaxFeatureLevel);
  const LevelMatrix ground =
      LevelMatrix::NullaryExpr(50, 55, [&] { return static_cast<std::int8_t>(level(random)); });
  const LevelMatrix a = ground.leftCols(50), b = ground.rightCols(50);
  EXPECT_EQ(Aligner().align(a, b).shift, -5);
  const Alignment printed = Aligner({DistanceForm::kPrinted, 0.3, 0}).align(a, b);
  EXPECT_EQ(std::abs(printed.shift), 35);
  EXPECT_FALSE(printed.valid);
}

TEST(Alignment, WindowsWithoutEnergyInCommonAreInvalid) {
  LevelMatrix a = LevelMatrix::Zero(5, 20), b = a;
  EXPECT_FALSE(Aligner().align(a, b).valid);
  a(2, 0) = 5;  // meets b's only at a shift beyond the limit
  b(2, 19) = 5;
  EXPECT_FALSE(Aligner().align(a, b).valid);
  EXPECT_THROW(Aligner().align(a, LevelMatrix::Zero(5, 21)), std::invalid_argument);
}

// A smooth random field, moved by fractions of a column under noise: the place is found to what the
// variance says, within a factor of two in standard deviation.
TEST(Alignment, SubcolumnErrorAgreesWithItsVariance) {
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> phase(0.0, 6.283), place(-3.0, 3.0), wave_number(0.2, 0.9);
  constexpr int kRows = 40, kColumns = 50, kTrials = 200;
  double squared = 0.0, variance = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double shift = place(random);
    Eigen::MatrixXf a = Eigen::MatrixXf::Zero(kRows, kColumns), b = a;
    for (int r = 0; r < kRows; ++r) {
      for (int wave = 0; wave < 3; ++wave) {
        const double k = wave_number(random), p = phase(random);
        for (int c = 0; c < kColumns; ++c) {
          a(r, c) += static_cast<float>(std::sin(k * c + p));
          b(r, c) += static_cast<float>(std::sin(k * (c - shift) + p));
        }
      }
    }
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      a.data()[i] += static_cast<float>(2.0 * normal(random));
      b.data()[i] += static_cast<float>(2.0 * normal(random));
    }
    const Alignment alignment = Aligner().align(a, b);
    ASSERT_TRUE(alignment.valid);
    squared += std::pow(alignment.subcolumn - shift, 2);
    variance += alignment.variance;
  }
  EXPECT_LT(squared / variance, 4.0);
  EXPECT_GT(squared / variance, 0.1);
}

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
