// Dot products of contiguous arrays, the inner loop of every shift search. Single precision is
// summed in the same order on every machine, in registers of 16 bytes, which SSE2 and NEON have. Of
// 16-bit levels, whose sum is exact, x86-64 has an instruction of its own; elsewhere the compiler
// finds it.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace gprodom::gpr {

// Values must be small enough for the sum to fit 32 bits (levels 0..10: up to 21 million cells).
inline std::int32_t dot_product(const std::int16_t* a, const std::int16_t* b, std::size_t n) {
  std::size_t i = 0;
  std::int32_t sum = 0;
#if defined(__SSE2__)
  const auto products = [a, b](std::size_t at) {
    return _mm_madd_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(a + at)),
                          _mm_loadu_si128(reinterpret_cast<const __m128i*>(b + at)));
  };
  __m128i sum0 = _mm_setzero_si128(), sum1 = sum0, sum2 = sum0, sum3 = sum0;
  for (; i + 32 <= n; i += 32) {
    sum0 = _mm_add_epi32(sum0, products(i));
    sum1 = _mm_add_epi32(sum1, products(i + 8));
    sum2 = _mm_add_epi32(sum2, products(i + 16));
    sum3 = _mm_add_epi32(sum3, products(i + 24));
  }
  sum0 = _mm_add_epi32(_mm_add_epi32(sum0, sum1), _mm_add_epi32(sum2, sum3));
  for (; i + 8 <= n; i += 8) sum0 = _mm_add_epi32(sum0, products(i));
  alignas(16) std::int32_t lanes[4];
  _mm_store_si128(reinterpret_cast<__m128i*>(lanes), sum0);
  sum = lanes[0] + lanes[1] + lanes[2] + lanes[3];
#endif
  for (; i < n; ++i) sum += static_cast<std::int32_t>(a[i]) * b[i];
  return sum;
}

// Lanes are summed in single precision and gathered in double every few thousand products.
inline double dot_product(const float* a, const float* b, std::size_t n) {
  typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));
  const auto products = [a, b](std::size_t at) {
    return *reinterpret_cast<const Four*>(a + at) * *reinterpret_cast<const Four*>(b + at);
  };
  constexpr std::size_t kBlock = 4096;
  double total = 0.0;
  std::size_t i = 0;
  while (i + 16 <= n) {
    const std::size_t end = n - i > kBlock ? i + kBlock : n;
    Four sum0{}, sum1{}, sum2{}, sum3{};
    for (; i + 16 <= end; i += 16) {
      sum0 += products(i);
      sum1 += products(i + 4);
      sum2 += products(i + 8);
      sum3 += products(i + 12);
    }
    const Four lanes = (sum0 + sum1) + (sum2 + sum3);
    total += static_cast<double>(lanes[0]) + lanes[1] + lanes[2] + lanes[3];
  }
  for (; i < n; ++i) total += static_cast<double>(a[i]) * b[i];
  return total;
}

}  // namespace gprodom::gpr
