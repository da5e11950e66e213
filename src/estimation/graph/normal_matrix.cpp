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

bool NormalMatrix::factorise(double damping) {
  if (slots_.empty()) find_slots();
  factorised_.setShift(0.0, 1.0 + damping);
  factorised_.factorize(matrix_);
  return factorised_.info() == Eigen::Success;
}

}  // namespace gprodom
