// What the search for revisits computes with, against the plain formulas.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "gpr/kernels/add_multiple.h"
#include "gpr/revisit/band_limit.h"
#include "gpr/revisit/matrix_product.h"
#include "gpr/revisit/patch_filter.h"
#include "gpr/revisit/row_sums.h"

namespace gprodom::gpr {
namespace {

// Shorter than a register, some whole ones, and some with a rest.
TEST(AddMultiple, IsThatOfEachEntryWhateverTheLength) {
  for (const int n : {1, 7, 16, 37}) {
    const Eigen::VectorXf of = Eigen::VectorXf::Random(n), before = Eigen::VectorXf::Random(n + 2);
    Eigen::VectorXf to = before;
    add_multiple(-0.3F, of.data(), n, &to[1]);
    for (int i = 0; i < n; ++i) EXPECT_FLOAT_EQ(to[i + 1], before[i + 1] - 0.3F * of[i]);
    EXPECT_EQ(to[0], before[0]);
    EXPECT_EQ(to[n + 1], before[n + 1]);
  }
}

// Below a tile, one tile, and a length that is no multiple of it.
TEST(RowSums, AddsPiecesOfRows) {
  constexpr int kRows = 3, kStride = 120;
  std::vector<float> table(kRows * kStride);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i % 37);
  const int begin[kRows] = {5, 0, 13};
  for (const int n : {1, 31, 32, 77}) {
    std::vector<float> sum(n, -1.0F);
    sum_rows(table.data(), kStride, begin, kRows, n, sum.data());
    for (int k = 0; k < n; ++k) {
      float expected = 0.0F;
      for (int i = 0; i < kRows; ++i) expected += table[i * kStride + begin[i] + k];
      EXPECT_EQ(sum[k], expected) << n << " " << k;
    }
  }
}

TEST(RowSums, MayUseOneRowAgainAndAgain) {
  const std::vector<float> row = {1, 2, 3, 4};
  const int begin[] = {0, 1, 2};
  float sum[2];
  sum_rows(row.data(), 0, begin, 3, 2, sum);
  EXPECT_EQ(sum[0], 6.0F);
  EXPECT_EQ(sum[1], 9.0F);
}

TEST(MatrixProduct, IsThatOfEigenWhateverTheSizes) {
  for (const int m : {1, 5, 6, 13}) {
    for (const int n : {1, 8, 11}) {
      for (const int k : {1, 7}) {
        const Columns all_a = Columns::Random(m, k + 3), all_b = Columns::Random(n, k + 3);
        const auto a = all_a.middleCols(2, k), b = all_b.middleCols(1, k);  // with strides
        Columns out = Columns::Constant(m, n + 2, 7.0F);
        multiply_by_rows(a, b, out);
        EXPECT_LT((out.leftCols(n) - a * b.transpose()).cwiseAbs().maxCoeff(), 1e-5F);
        EXPECT_TRUE((out.rightCols(2).array() == 7.0F).all());  // what is beyond stays
      }
    }
  }
}

// Mean of the rows that are within `half` of each row.
Columns mean_of_neighbours(const Columns& in, Eigen::Index half) {
  Columns out(in.rows(), in.cols());
  for (Eigen::Index i = 0; i < in.rows(); ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - half);
    const Eigen::Index last = std::min(in.rows() - 1, i + half);
    out.row(i) = in.middleRows(first, last - first + 1).colwise().mean();
  }
  return out;
}

// A sigma of 3 columns is that of three means over 3 columns to either side. Fewer columns than
// that, and more.
TEST(PatchFilter, SmoothsByThreeRunningMeans) {
  for (const int n : {1, 2, 4, 7, 40}) {
    const Columns columns = Columns::Random(n, 11);
    Columns expected = columns;
    for (int pass = 0; pass < 3; ++pass) expected = mean_of_neighbours(expected, 3);
    Columns smooth = columns;
    smooth_along(3.0, smooth);
    EXPECT_LT((smooth - expected).cwiseAbs().maxCoeff(), 1e-6F) << n;
  }
}

// Away from the ends, over the periods that features have.
TEST(PhaseTurn, TurnsEachFrequencyByTheAngle) {
  constexpr int kRows = 80, kEnd = 20;
  for (const double angle : {-0.7, 0.4, 1.2, 0.5 * M_PI}) {
    const Columns turn = phase_turn(kRows, angle);
    for (const double period : {2.5, 4.0, 7.0, 11.0}) {
      Columns wave(1, kRows);
      for (int row = 0; row < kRows; ++row)
        wave(0, row) = static_cast<float>(std::cos(2 * M_PI * row / period));
      const Columns turned = wave * turn.transpose();
      for (int row = kEnd; row < kRows - kEnd; ++row) {
        EXPECT_NEAR(turned(0, row), std::cos(2 * M_PI * row / period + angle), 0.08)
            << angle << " " << period << " " << row;
      }
    }
  }
}

}  // namespace
}  // namespace gprodom::gpr
