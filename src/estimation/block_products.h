// Products of the small blocks of the smoother's normal equations. For matrices of this size Eigen
// uses its kernels for large ones, in which packing costs more than the product.
#pragma once

#include <Eigen/Core>

#include "estimation/nav_state.h"

namespace gprodom {

// Groups of four columns with values other than zero, one bit each, in rows of 16 doubles.
using ColumnGroups = unsigned;
constexpr ColumnGroups kAllColumns = 0xF;
inline ColumnGroups column_groups(const double* rows, int count) {
  using Four = Eigen::Array4d;
  ColumnGroups used = 0;
  for (int group = 0; group < kStateDim / 4; ++group) {
    Four sum = Four::Zero();
    for (int r = 0; r < count; ++r)
      sum += Eigen::Map<const Four>(rows + r * kStateDim + 4 * group).abs();
    if (!(sum.sum() == 0.0)) used |= 1U << group;
  }
  return used;
}

// C += or -= sum over r of column_r(A) row_r(B) with A and B given by rows of 16 doubles each:
// C(i, j) += sign sum_r A[r][i] B[r][j]. Tiles of 4 x 4 stay in registers. kLower: only those on
// and below the diagonal, for a symmetric C. Columns outside the given groups must be zero.
enum class Part { kAll, kLower };
template <int kSign, Part kPart>
inline void add_outer_products(const double* A, const double* B, int rows, StateMatrix& C,
                               ColumnGroups in_A = kAllColumns, ColumnGroups in_B = kAllColumns) {
  using Four = Eigen::Array4d;
  constexpr int n = kStateDim;
  for (int j = 0; j < n; j += 4) {
    if (!(in_B >> (j / 4) & 1U)) continue;
    for (int i = kPart == Part::kLower ? j : 0; i < n; i += 4) {
      if (!(in_A >> (i / 4) & 1U)) continue;
      Four c0 = Four::Zero(), c1 = c0, c2 = c0, c3 = c0;
      for (int r = 0; r < rows; ++r) {
        const Four a = Eigen::Map<const Four>(A + r * n + i);
        const double* b = B + r * n + j;
        c0 += a * b[0];
        c1 += a * b[1];
        c2 += a * b[2];
        c3 += a * b[3];
      }
      double* c = C.data() + i + j * n;
      Eigen::Map<Four>{c} += kSign * c0;
      Eigen::Map<Four>{c + n} += kSign * c1;
      Eigen::Map<Four>{c + 2 * n} += kSign * c2;
      Eigen::Map<Four>{c + 3 * n} += kSign * c3;
    }
  }
}

// C -= A B^T: columns of a column-major matrix are the rows of its transpose.
template <Part kPart>
inline void subtract_product(const StateMatrix& A, const StateMatrix& B, StateMatrix& C) {
  add_outer_products<-1, kPart>(A.data(), B.data(), kStateDim, C);
}

// X <- X L^-T with L lower triangular, column by column.
inline void solve_transposed_on_the_right(const StateMatrix& L, StateMatrix& X) {
  for (int j = 0; j < kStateDim; ++j) {
    StateVector x = X.col(j);
    for (int k = 0; k < j; ++k) x -= L(j, k) * X.col(k);
    X.col(j) = x / L(j, j);
  }
}

}  // namespace gprodom
