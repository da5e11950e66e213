// Products and the elimination of the small blocks of the smoother's normal equations. For matrices
// of this size Eigen uses its kernels for large ones, in which packing costs more than the product.
// Each sum is taken in the same order on every machine.
#pragma once

#include <Eigen/Core>

namespace gprodom {

constexpr int kBlockSize = 16;
using Block = Eigen::Matrix<double, kBlockSize, kBlockSize>;

// Groups of four columns with values other than zero, one bit each, in rows of 16 doubles.
using ColumnGroups = unsigned;
constexpr ColumnGroups kAllColumns = 0xF;

// Scales each of `count` rows of 16 doubles by the units, entry by entry. Returns the groups of
// columns that are not zero.
ColumnGroups scale_columns(double* rows, int count,
                           const Eigen::Matrix<double, kBlockSize, 1>& units);

// sum += each of `count` rows of 16 doubles times its weight.
void add_rows(const double* rows, const double* weights, int count,
              Eigen::Matrix<double, kBlockSize, 1>& sum);

// Some rows of 16 doubles. Columns outside the given groups must be zero.
struct BlockRows {
  const double* first;
  ColumnGroups columns = kAllColumns;
};

// kLower: only the tiles of 4 x 4 on and below the diagonal, for a symmetric result.
enum class Part { kAll, kLower };

// C(i, j) += sum over r of A[r][i] B[r][j], over `rows` rows.
void add_product(BlockRows A, BlockRows B, int rows, Part part, Block& C);

// C -= A B^T.
void subtract_product(const Block& A, const Block& B, Part part, Block& C);

// X <- X L^-T with L lower triangular.
void solve_transposed_on_the_right(const Block& L, Block& X);

// The lower triangle of A becomes that of L with L L^T = A; what is above the diagonal is undefined
// then. false: A is not positive definite.
bool cholesky(Block& A);

// F P F^T.
Eigen::Matrix<double, 9, 9> propagated_covariance(const Eigen::Matrix<double, 9, kBlockSize>& F,
                                                  const Block& P);

}  // namespace gprodom
