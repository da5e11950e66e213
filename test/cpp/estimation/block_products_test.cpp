// The products and the elimination of blocks against Eigen's.
#include "estimation/kernels/block_products.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>

#include "estimation/graph/normal_matrix.h"
#include "support/noise.h"

namespace gprodom {
namespace {

Block random_matrix(unsigned seed) {
  Noise normal(seed);
  return Block::NullaryExpr([&] { return normal(); });
}

using Rows = Eigen::Matrix<double, 5, kBlockSize, Eigen::RowMajor>;

TEST(BlockProducts, AddRowsByRowsWhereTheyAreNotZero) {
  Rows A = random_matrix(1).topRows<5>(), B = random_matrix(2).topRows<5>();
  A.middleCols<4>(8).setZero();
  const Rows unscaled = A;
  Eigen::Matrix<double, kBlockSize, 1> units = random_matrix(3).col(0);
  const ColumnGroups groups = scale_columns(A.data(), 5, units);
  EXPECT_EQ(groups, 0b1011U);
  EXPECT_TRUE(A.isApprox(unscaled * units.asDiagonal()));
  const Block before = random_matrix(4);
  Block C = before;
  add_product({A.data(), groups}, {B.data()}, 5, Part::kAll, C);
  EXPECT_TRUE(C.isApprox(before + A.transpose() * B));
  C = before;
  add_product({A.data(), groups}, {A.data(), groups}, 5, Part::kLower, C);
  const Block all = before + A.transpose() * A;
  EXPECT_TRUE(
      Block(C.triangularView<Eigen::Lower>()).isApprox(Block(all.triangularView<Eigen::Lower>())));
}

TEST(BlockProducts, NoRootOfWhatIsNotPositiveDefinite) {
  Block A = Block::Identity();
  A(9, 9) = -1.0;
  EXPECT_FALSE(cholesky(A));
}

TEST(BlockProducts, CovarianceIsPropagated) {
  const Eigen::Matrix<double, 9, kBlockSize> F = random_matrix(7).topRows<9>();
  const Block P = random_matrix(8);
  EXPECT_TRUE(propagated_covariance(F, P).isApprox(F * P * F.transpose()));
}

using Vector2 = Eigen::Matrix<double, 2, 1>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;

// The second pass has other values, some of them zero, at the same places; an unknown may be left
// out, and the first entry of a pair may be the larger number.
TEST(NormalMatrix, EveryPassGivesTheDenseSolution) {
  constexpr int kUnknowns = 6;
  const std::array<std::array<int, 3>, 5> unknowns = {
      {{0, 1, 2}, {5, 1, 3}, {kNoUnknown, 4, 2}, {3, 4, 5}, {2, 0, 5}}};
  Noise normal(1);
  NormalMatrix sparse(kUnknowns);
  for (int pass = 0; pass < 3; ++pass) {
    sparse.clear();
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(kUnknowns);
    for (std::size_t f = 0; f < unknowns.size(); ++f) {
      const Matrix23 J = Matrix23::NullaryExpr([&] { return normal(); });
      const Vector2 r = Vector2::NullaryExpr([&] { return normal(); });
      const double weight = pass == 1 && f == 4 ? 0.0 : 1.5;
      sparse.add<2, 3>(unknowns[f], J, r, weight);
      Eigen::MatrixXd all = Eigen::MatrixXd::Zero(2, kUnknowns);
      for (int k = 0; k < 3; ++k) {
        if (unknowns[f][k] != kNoUnknown) all.col(unknowns[f][k]) = J.col(k);
      }
      H += weight * all.transpose() * all;
      g += weight * all.transpose() * r;
    }
    sparse.hold(0, 3.0);
    H(0, 0) += 3.0;
    H.diagonal() *= 1.0 + 0.1 * pass;
    ASSERT_TRUE(sparse.factorise(0.1 * pass));
    EXPECT_LT((sparse.gradient() - g).norm(), 1e-12);
    EXPECT_LT((sparse.solve(sparse.gradient()) - H.llt().solve(g)).norm(), 1e-9) << "pass " << pass;
  }
}

// LDL^T of it exists.
TEST(NormalMatrix, IndefiniteEquationsAreRefused) {
  NormalMatrix sparse(2);
  sparse.clear();
  sparse.hold(0, 1.0);
  sparse.hold(1, -1e-3);
  EXPECT_FALSE(sparse.factorise());
}

}  // namespace
}  // namespace gprodom
