#include "gpr/kernels/add_multiple.h"

#include "base/processor.h"

namespace gprodom::gpr {
namespace {

GPRODOM_ALSO_FOR_AVX2
void add_here(float factor, const float* __restrict of, std::ptrdiff_t n, float* __restrict to) {
  for (std::ptrdiff_t i = 0; i < n; ++i) to[i] += factor * of[i];
}

}  // namespace

void add_multiple(float factor, const float* of, std::ptrdiff_t n, float* to) {
  add_here(factor, of, n, to);
}

}  // namespace gprodom::gpr
