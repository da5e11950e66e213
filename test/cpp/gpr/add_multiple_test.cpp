#include "gpr/kernels/add_multiple.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

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

}  // namespace
}  // namespace gprodom::gpr
