// Products of many short rows with each other, the inner loop of the revisit search. Processor
// features are chosen at run time; each sum is taken in the same order everywhere, so that every
// machine finds the same numbers.
#pragma once

#include <Eigen/Core>

#include "gpr/revisit/patch_filter.h"

namespace gprodom::gpr {

// out(i, j) = a.row(i) . b.row(j), a (m, k), b (n, k), into the first n columns of out (m, >= n).
void multiply_by_rows(const Eigen::Ref<const Columns, 0, Eigen::OuterStride<>>& a,
                      const Eigen::Ref<const Columns, 0, Eigen::OuterStride<>>& b,
                      Eigen::Ref<Columns, 0, Eigen::OuterStride<>> out);

}  // namespace gprodom::gpr
