// Sums of rows of a table, an inner loop of the revisit search. The rows are added in the same
// order on every machine.
#pragma once

#include <cstddef>

namespace gprodom::gpr {

// sum[0 .. n) = sum over i of table[i * stride + begin[i] ..]. `stride` is the distance between
// rows; 0: all are the same row. The sum stays in registers, so the table is read once and the sum
// written once.
void sum_rows(const float* table, std::ptrdiff_t stride, const int* begin, int rows,
              std::ptrdiff_t n, float* sum);

}  // namespace gprodom::gpr
