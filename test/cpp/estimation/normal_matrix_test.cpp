#include "estimation/graph/normal_matrix.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>

#include "support/noise.h"

namespace gprodom {
namespace {

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
