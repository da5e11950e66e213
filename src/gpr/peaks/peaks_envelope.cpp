#include "gpr/peaks/peaks_envelope.h"

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace gprodom::gpr {
namespace {

constexpr int kTerms = 16;           // odd k: 1, 3, ..., 31
constexpr int kMargin = 2 * kTerms;  // zeros on either side

std::array<float, kTerms> hilbert_taps() {
  std::array<float, kTerms> taps{};
  for (int j = 0; j < kTerms; ++j) {
    const double k = 2 * j + 1;
    taps[j] =
        static_cast<float>(2.0 / (M_PI * k) * (0.54 + 0.46 * std::cos(M_PI * k / (2 * kTerms))));
  }
  return taps;
}

}  // namespace

void analytic_signal(const float* trace, std::size_t size, AnalyticSignal& signal) {
  static const std::array<float, kTerms> taps = hilbert_taps();
  const auto n = static_cast<Eigen::Index>(size);
  signal.real.resize(size);
  signal.imaginary.resize(size);
  signal.envelope.resize(size);
  signal.padded.resize(size + 2 * kMargin);
  if (size == 0) return;

  const Eigen::Map<const Eigen::ArrayXf> x(trace, n);
  Eigen::Map<Eigen::ArrayXf> real(signal.real.data(), n);
  Eigen::Map<Eigen::ArrayXf> imaginary(signal.imaginary.data(), n);
  Eigen::Map<Eigen::ArrayXf> padded(signal.padded.data(), n + 2 * kMargin);
  real = x - x.mean();
  padded.head(kMargin).setZero();
  padded.segment(kMargin, n) = real;
  padded.tail(kMargin).setZero();

  // y[i] = sum over odd k of h[k] (x[i - k] - x[i + k]), four taps in a pass.
  imaginary.setZero();
  for (int j = 0; j < kTerms; j += 4) {
    const auto pair = [&padded, n](int tap) {
      const int k = 2 * tap + 1;
      return padded.segment(kMargin - k, n) - padded.segment(kMargin + k, n);
    };
    imaginary += taps[j] * pair(j) + taps[j + 1] * pair(j + 1) + taps[j + 2] * pair(j + 2) +
                 taps[j + 3] * pair(j + 3);
  }
  Eigen::Map<Eigen::ArrayXf>(signal.envelope.data(), n) =
      (real.square() + imaginary.square()).sqrt();
}

}  // namespace gprodom::gpr
