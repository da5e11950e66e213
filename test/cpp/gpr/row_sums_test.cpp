#include "gpr/revisit/row_sums.h"

#include <gtest/gtest.h>

#include <vector>

namespace gprodom::gpr {
namespace {

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

}  // namespace
}  // namespace gprodom::gpr
