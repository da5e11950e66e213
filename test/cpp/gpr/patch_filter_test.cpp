#include "gpr/revisit/patch_filter.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace gprodom::gpr {
namespace {

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

}  // namespace
}  // namespace gprodom::gpr
