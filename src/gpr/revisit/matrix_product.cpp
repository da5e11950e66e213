#include "gpr/revisit/matrix_product.h"

#include <algorithm>
#include <cstring>

#include "base/processor.h"

namespace gprodom::gpr {
namespace {

constexpr int kWide = 8;  // columns of a tile
constexpr int kHigh = 6;  // rows of it: with SSE2 alone, twelve of the sixteen registers

typedef float Wide __attribute__((vector_size(kWide * sizeof(float))));

struct Rows {
  float* first;
  std::ptrdiff_t stride;
};

// out (kHigh * tiles, kWide) = a (kHigh * tiles, k) by the columns of panel (k, kWide).
GPRODOM_ALSO_FOR_AVX2
void multiply_tiles(const float* a, std::ptrdiff_t stride, std::ptrdiff_t tiles, const float* panel,
                    int k, Rows out) {
  for (std::ptrdiff_t tile = 0; tile < tiles; ++tile, a += kHigh * stride) {
    Wide s0{}, s1{}, s2{}, s3{}, s4{}, s5{};
    for (int i = 0; i < k; ++i) {
      Wide b;
      std::memcpy(&b, panel + static_cast<std::ptrdiff_t>(i) * kWide, sizeof(b));
      s0 += a[i] * b;
      s1 += a[i + stride] * b;
      s2 += a[i + 2 * stride] * b;
      s3 += a[i + 3 * stride] * b;
      s4 += a[i + 4 * stride] * b;
      s5 += a[i + 5 * stride] * b;
    }
    float* row = out.first + tile * kHigh * out.stride;
    std::memcpy(row, &s0, sizeof(Wide));
    std::memcpy(row + out.stride, &s1, sizeof(Wide));
    std::memcpy(row + 2 * out.stride, &s2, sizeof(Wide));
    std::memcpy(row + 3 * out.stride, &s3, sizeof(Wide));
    std::memcpy(row + 4 * out.stride, &s4, sizeof(Wide));
    std::memcpy(row + 5 * out.stride, &s5, sizeof(Wide));
  }
}

}  // namespace

void multiply_by_rows(const Eigen::Ref<const Columns, 0, Eigen::OuterStride<>>& a,
                      const Eigen::Ref<const Columns, 0, Eigen::OuterStride<>>& b,
                      Eigen::Ref<Columns, 0, Eigen::OuterStride<>> out) {
  const auto k = static_cast<int>(a.cols());
  const Eigen::Index whole = a.rows() / kHigh * kHigh, left = a.rows() - whole;
  // The last rows of a with zeros below, a tile high.
  Columns rest = Columns::Zero(kHigh, k), tile(kHigh, kWide);
  rest.topRows(left) = a.bottomRows(left);
  Columns panel = Columns::Zero(k, kWide), part(whole, kWide);
  for (Eigen::Index column = 0; column < b.rows(); column += kWide) {
    const Eigen::Index width = std::min<Eigen::Index>(kWide, b.rows() - column);
    for (Eigen::Index j = 0; j < width; ++j) {
      panel.col(j) = b.row(column + j).transpose();
    }
    if (width == kWide) {
      multiply_tiles(a.data(), a.outerStride(), whole / kHigh, panel.data(), k,
                     {out.data() + column, out.outerStride()});
    } else {
      multiply_tiles(a.data(), a.outerStride(), whole / kHigh, panel.data(), k,
                     {part.data(), kWide});
      out.block(0, column, whole, width) = part.leftCols(width);
    }
    if (left == 0) continue;
    multiply_tiles(rest.data(), k, 1, panel.data(), k, {tile.data(), kWide});
    out.block(whole, column, left, width) = tile.topLeftCorner(left, width);
  }
}

}  // namespace gprodom::gpr
