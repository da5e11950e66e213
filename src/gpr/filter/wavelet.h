// Stationary wavelet transform of a trace and soft thresholding of its details.
//
// The transform is shift-invariant: no level is decimated, so a reflection keeps its shape wherever
// it lies. With low-pass h and high-pass g of length L, a_0 = x and step s = 2^(l-1),
//   a_l[i] = sum_j h[j] a_{l-1}[(i + (L/2 - j) s) mod n],   d_l[i] = the same with g
// (G. P. Nason, B. W. Silverman 1995; extension and alignment as in PyWavelets' swt with default
// arguments), and back, averaging over both decimations,
//   a_{l-1}[i] = 1/2 sum_j (h[j] a_l[(i - (L/2 - j) s) mod n] + g[j] d_l[(i - (L/2 - j) s) mod n]).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "gprodom/choices.h"

namespace gprodom::gpr {

enum class WaveletKind {
  kDb1,
  kDb2,
  kDb3,
  kDb4,
  kDb5,
  kDb6,
  kDb7,
  kDb8,
  kSym4,
  kSym5,
  kSym6,
  kSym8,
  kNone
};
constexpr std::array<const char*, 13> names_like(WaveletKind) {
  return {"db1", "db2",  "db3",  "db4",  "db5",  "db6", "db7",
          "db8", "sym4", "sym5", "sym6", "sym8", "none"};
}
static_assert(names_like(WaveletKind{}).size() == std::size_t(WaveletKind::kNone) + 1);

// Orthogonal analysis filters. Both have unit norm, so white noise keeps its standard deviation at
// each level.
struct Wavelet {
  std::vector<double> low;   // h, sum sqrt(2)
  std::vector<double> high;  // g[j] = (-1)^(j+1) h[L-1-j]
};

// Daubechies' "db1" to "db8", of extremal phase, and "sym4", "sym5", "sym6" and "sym8", nearest to
// linear phase: found by spectral factorisation, to 1e-11. Throws std::invalid_argument on kNone.
Wavelet make_wavelet(WaveletKind kind);

// T is float or double. Buffers are kept: no allocation after the first call of a length.
template <typename T>
class StationaryWavelet {
 public:
  // levels >= 1.
  StationaryWavelet(const Wavelet& wavelet, int levels);

  int levels() const { return levels_; }
  // Lengths must be multiples of 2^levels: the next one.
  int padded(int n) const;

  // x: n samples -> details: levels x n, finest level first; approximation: n, of the last level
  // (nullptr: not needed).
  // Throws std::invalid_argument if n is not a multiple of 2^levels.
  void forward(const T* x, int n, T* details, T* approximation);
  // The inverse, to x. approximation nullptr: zero.
  void inverse(const T* details, const T* approximation, int n, T* x);

 private:
  void check(int n) const;
  // Copies n samples to extended_, periodically continued by `left` and `right` samples.
  void extend(const T* x, int n, int left, int right, std::vector<T>& out) const;

  int levels_;
  std::vector<T> low_, high_;
  std::vector<T> extended_, extended_details_, low_out_, high_out_;
};

// sign(v) max(|v| - threshold, 0), in place.
template <typename T>
void soft_threshold(T* values, int n, T threshold);

// Standard deviation of Gaussian noise among n values of which fewer than half hold signal: the
// median of |v| over 0.6745 (D. L. Donoho 1995). scratch: 2 n values, overwritten.
template <typename T>
T noise_sigma(const T* values, int n, T* scratch);

// Detail preservation and restoration: approximation zeroed, details soft-thresholded at
// `threshold` times sigma sqrt(2 ln n), sigma from the finest details, transformed back.
template <typename T>
class DetailDenoiser {
 public:
  DetailDenoiser(const Wavelet& wavelet, int levels, double threshold);

  // x: n samples of any number -> out, which may be x. A length that is no multiple of 2^levels is
  // continued by its mirror image. Returns sigma.
  T apply(const T* x, int n, T* out);

 private:
  StationaryWavelet<T> transform_;
  T threshold_;
  std::vector<T> padded_, details_, scratch_;
};

}  // namespace gprodom::gpr
