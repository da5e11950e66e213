#include "estimation/kernels/block_products.h"

#include <cmath>

#include "base/processor.h"

namespace gprodom {

namespace {

constexpr int kN = kBlockSize, kGroups = kN / 4;

// Four neighbours of a column: one register of AVX2, or two of SSE2.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
Four* fours(double* x) { return reinterpret_cast<Four*>(x); }
const Four* fours(const double* x) { return reinterpret_cast<const Four*>(x); }

// Tiles of 4 x 4 stay in registers.
template <int kSign>
__attribute__((always_inline)) inline void add_tiles(const BlockRows& A, const BlockRows& B,
                                                     int rows, Part part, double* C) {
  for (int j = 0; j < kGroups; ++j) {
    if (!(B.columns >> j & 1U)) continue;
    for (int i = part == Part::kLower ? j : 0; i < kGroups; ++i) {
      if (!(A.columns >> i & 1U)) continue;
      Four c0{}, c1{}, c2{}, c3{};
      for (int r = 0; r < rows; ++r) {
        const Four& a = fours(A.first)[r * kGroups + i];
        const double* b = B.first + r * kN + 4 * j;
        c0 += a * b[0];
        c1 += a * b[1];
        c2 += a * b[2];
        c3 += a * b[3];
      }
      Four* c = fours(C) + i + 4 * j * kGroups;
      c[0] += kSign * c0;
      c[kGroups] += kSign * c1;
      c[2 * kGroups] += kSign * c2;
      c[3 * kGroups] += kSign * c3;
    }
  }
}

GPRODOM_ALSO_FOR_AVX2
ColumnGroups scale_columns_here(double* rows, int count,
                                const Eigen::Matrix<double, kBlockSize, 1>& units) {
  const Four* unit = fours(units.data());
  Four sum0{}, sum1{}, sum2{}, sum3{};
  for (int r = 0; r < count; ++r) {
    Four* x = fours(rows) + r * kGroups;
    x[0] *= unit[0];
    x[1] *= unit[1];
    x[2] *= unit[2];
    x[3] *= unit[3];
    sum0 += x[0] * x[0];
    sum1 += x[1] * x[1];
    sum2 += x[2] * x[2];
    sum3 += x[3] * x[3];
  }
  const auto bit = [](const Four& sum, ColumnGroups group) {
    return sum[0] + sum[1] + sum[2] + sum[3] == 0.0 ? 0U : group;
  };
  return bit(sum0, 1U) | bit(sum1, 2U) | bit(sum2, 4U) | bit(sum3, 8U);
}

GPRODOM_ALSO_FOR_AVX2
void add_rows_here(const double* rows, const double* weights, int count, double* sum) {
  for (int i = 0; i < kGroups; ++i) {
    Four all{};
    for (int r = 0; r < count; ++r) all += fours(rows)[r * kGroups + i] * weights[r];
    fours(sum)[i] += all;
  }
}

GPRODOM_ALSO_FOR_AVX2
void add_product_here(BlockRows A, BlockRows B, int rows, Part part, Block& C) {
  add_tiles<1>(A, B, rows, part, C.data());
}

// Columns of a column-major matrix are the rows of its transpose.
GPRODOM_ALSO_FOR_AVX2
void subtract_product_here(const Block& A, const Block& B, Part part, Block& C) {
  add_tiles<-1>({A.data()}, {B.data()}, kN, part, C.data());
}

GPRODOM_ALSO_FOR_AVX2
void solve_transposed_on_the_right_here(const Block& L, Block& X) {
  Four* columns = fours(X.data());
  for (int j = 0; j < kN; ++j) {
    Four* x = columns + j * kGroups;
    Four x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
    for (int k = 0; k < j; ++k) {
      const Four* known = columns + k * kGroups;
      const double l = L.data()[j + k * kN];
      x0 -= l * known[0];
      x1 -= l * known[1];
      x2 -= l * known[2];
      x3 -= l * known[3];
    }
    const double pivot = L.data()[j + j * kN];
    x[0] = x0 / pivot;
    x[1] = x1 / pivot;
    x[2] = x2 / pivot;
    x[3] = x3 / pivot;
  }
}

// Column by column, each less its products with those before it.
GPRODOM_ALSO_FOR_AVX2
bool cholesky_here(Block& A) {
  double* const a = A.data();
  for (int j = 0; j < kN; ++j) {
    double square = 0.0;
    for (int k = 0; k < j; ++k) square += a[j + k * kN] * a[j + k * kN];
    const double rest = a[j + j * kN] - square;
    if (rest <= 0.0) return false;
    const double pivot = std::sqrt(rest);
    for (int i = j / 4; i < kGroups; ++i) {
      Four sum{};
      for (int k = 0; k < j; ++k) sum += fours(a)[i + k * kGroups] * a[j + k * kN];
      Four& column = fours(a)[i + j * kGroups];
      column = (column - sum) / pivot;
    }
    a[j + j * kN] = pivot;
  }
  return true;
}

// Columns of nine, with zeros below to three registers.
GPRODOM_ALSO_FOR_AVX2
Eigen::Matrix<double, 9, 9> propagated_covariance_here(
    const Eigen::Matrix<double, 9, kBlockSize>& F, const Block& P) {
  constexpr int kRows = 9, kHigh = 3;
  Four f[kN * kHigh] = {}, fp[kN * kHigh];
  for (int k = 0; k < kN; ++k)
    for (int i = 0; i < kRows; ++i) f[k * kHigh + i / 4][i % 4] = F(i, k);
  for (int j = 0; j < kN; ++j) {
    Four a{}, b{}, c{};
    for (int k = 0; k < kN; ++k) {
      a += f[k * kHigh] * P(k, j);
      b += f[k * kHigh + 1] * P(k, j);
      c += f[k * kHigh + 2] * P(k, j);
    }
    fp[j * kHigh] = a;
    fp[j * kHigh + 1] = b;
    fp[j * kHigh + 2] = c;
  }
  Eigen::Matrix<double, 9, 9> out;
  for (int j = 0; j < kRows; ++j) {
    Four column[kHigh] = {};
    for (int k = 0; k < kN; ++k) {
      column[0] += fp[k * kHigh] * F(j, k);
      column[1] += fp[k * kHigh + 1] * F(j, k);
      column[2] += fp[k * kHigh + 2] * F(j, k);
    }
    for (int i = 0; i < kRows; ++i) out(i, j) = column[i / 4][i % 4];
  }
  return out;
}

}  // namespace

ColumnGroups scale_columns(double* rows, int count,
                           const Eigen::Matrix<double, kBlockSize, 1>& units) {
  return scale_columns_here(rows, count, units);
}

void add_rows(const double* rows, const double* weights, int count,
              Eigen::Matrix<double, kBlockSize, 1>& sum) {
  add_rows_here(rows, weights, count, sum.data());
}

void add_product(BlockRows A, BlockRows B, int rows, Part part, Block& C) {
  add_product_here(A, B, rows, part, C);
}

void subtract_product(const Block& A, const Block& B, Part part, Block& C) {
  subtract_product_here(A, B, part, C);
}

void solve_transposed_on_the_right(const Block& L, Block& X) {
  solve_transposed_on_the_right_here(L, X);
}

bool cholesky(Block& A) { return cholesky_here(A); }

Eigen::Matrix<double, 9, 9> propagated_covariance(const Eigen::Matrix<double, 9, kBlockSize>& F,
                                                  const Block& P) {
  return propagated_covariance_here(F, P);
}

}  // namespace gprodom
