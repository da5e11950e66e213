#include "gpr/revisit/row_sums.h"

#include <algorithm>

#include "base/processor.h"

namespace gprodom::gpr {
namespace {

// One register of AVX2, or two of SSE2.
typedef float Eight __attribute__((vector_size(32), aligned(4), may_alias));
constexpr std::ptrdiff_t kTile = 32;

GPRODOM_ALSO_FOR_AVX2
void sum_rows_here(const float* table, std::ptrdiff_t stride, const int* begin, int rows,
                   std::ptrdiff_t n, float* sum) {
  if (n < kTile) {
    std::fill_n(sum, n, 0.0F);
    for (int i = 0; i < rows; ++i) {
      const float* row = table + i * stride + begin[i];
      for (std::ptrdiff_t k = 0; k < n; ++k) sum[k] += row[k];
    }
    return;
  }
  for (std::ptrdiff_t tile = 0; tile < n; tile += kTile) {
    const std::ptrdiff_t k = std::min(tile, n - kTile);  // the last one overlaps
    Eight a{}, b{}, c{}, d{};
    for (int i = 0; i < rows; ++i) {
      const Eight* row = reinterpret_cast<const Eight*>(table + i * stride + begin[i] + k);
      a += row[0];
      b += row[1];
      c += row[2];
      d += row[3];
    }
    Eight* out = reinterpret_cast<Eight*>(sum + k);
    out[0] = a;
    out[1] = b;
    out[2] = c;
    out[3] = d;
  }
}

}  // namespace

void sum_rows(const float* table, std::ptrdiff_t stride, const int* begin, int rows,
              std::ptrdiff_t n, float* sum) {
  sum_rows_here(table, stride, begin, rows, n, sum);
}

}  // namespace gprodom::gpr
