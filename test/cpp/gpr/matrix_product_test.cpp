#include "gpr/revisit/matrix_product.h"

#include <gtest/gtest.h>

namespace gprodom::gpr {
namespace {

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

}  // namespace
}  // namespace gprodom::gpr
