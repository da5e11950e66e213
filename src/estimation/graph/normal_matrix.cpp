#include "estimation/graph/normal_matrix.h"

namespace gprodom {

void NormalMatrix::find_slots() {
  matrix_.setFromTriplets(entries_.begin(), entries_.end());
  slots_.reserve(entries_.size());
  const int* rows = matrix_.innerIndexPtr();
  for (const auto& entry : entries_) {
    const int* begin = rows + matrix_.outerIndexPtr()[entry.col()];
    const int* end = rows + matrix_.outerIndexPtr()[entry.col() + 1];
    slots_.push_back(static_cast<int>(std::lower_bound(begin, end, entry.row()) - rows));
  }
  entries_ = {};
  factorised_.analyzePattern(matrix_);
}

// A column of the factor with n entries below the diagonal takes n^2 / 2 products.
void NormalMatrix::count_work() {
  const auto& factor = factorised_.matrixL().nestedExpression();
  for (int k = 0; k < factor.outerSize(); ++k) {
    const double below = factor.outerIndexPtr()[k + 1] - factor.outerIndexPtr()[k];
    work_of_factorising_ += 0.5 * below * (below + 1.0);
  }
}

bool NormalMatrix::factorise(double damping) {
  if (slots_.empty()) find_slots();
  factorised_.setShift(0.0, 1.0 + damping);
  factorised_.factorize(matrix_);
  if (work_of_factorising_ == 0.0) count_work();
  work_ += work_of_factorising_;
  // LDL^T also exists where rounding has made the matrix indefinite.
  return factorised_.info() == Eigen::Success && factorised_.vectorD().minCoeff() > 0.0;
}

}  // namespace gprodom
