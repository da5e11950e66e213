#include "gpr/filter/band_pass.h"

#include <algorithm>
#include <cmath>

#include "base/require.h"
#include "gpr/kernels/lanes.h"

namespace gprodom::gpr {
namespace {

// Ideal low-pass response at `offset` samples from the centre; cutoff as a fraction of the sampling
// rate.
double ideal_low_pass(double cutoff, double offset) {
  return offset == 0.0 ? 2.0 * cutoff : std::sin(2.0 * M_PI * cutoff * offset) / (M_PI * offset);
}

}  // namespace

std::vector<double> design_band_pass(double low_hz, double high_hz, double sample_interval_s,
                                     double length_s) {
  const double low = low_hz * sample_interval_s;
  const double high = std::min(0.5, high_hz * sample_interval_s);
  require(
      low > 0.0 && low < 0.5 && low < high,
      "band-pass: expected 0 < low edge < high edge and a low edge below half the sampling rate");
  require(length_s >= 2.0 * sample_interval_s,
          "band-pass: expected a length of two samples or more");
  const int half = std::max(1, static_cast<int>(std::lround(0.5 * length_s / sample_interval_s)));
  const double middle = high < 0.5 ? 0.5 * (low + high) : 0.5;
  std::vector<double> taps;
  double gain = 0.0;
  for (int k = -half; k <= half; ++k) {
    const double window = 1.0 - std::abs(k) / (half + 1.0);
    const double tap = window * (ideal_low_pass(high, k) - ideal_low_pass(low, k));
    taps.push_back(tap);
    gain += tap * std::cos(2.0 * M_PI * middle * k);
  }
  for (double& tap : taps) tap /= gain;
  return taps;
}

template <typename T>
ZeroPhaseFilter<T>::ZeroPhaseFilter(const std::vector<double>& taps) {
  const int n = static_cast<int>(taps.size());
  for (int lag = 1 - n; lag < n; ++lag) {
    double sum = 0.0;
    for (int i = std::max(0, -lag); i < std::min(n, n - lag); ++i) sum += taps[i] * taps[i + lag];
    kernel_.push_back(static_cast<T>(sum));
  }
}

template <typename T>
void ZeroPhaseFilter<T>::apply(const T* x, int n, T* out) {
  if (kernel_.empty() || n < 1) {
    std::copy_n(x, std::max(n, 0), out);
    return;
  }
  const int taps = static_cast<int>(kernel_.size()), half = taps / 2, length = blocked<T>(n);
  extended_.resize(length + taps);
  result_.resize(length);
  std::fill_n(extended_.begin(), half, x[0]);
  std::copy_n(x, n, extended_.begin() + half);
  std::fill(extended_.begin() + half + n, extended_.end(), x[n - 1]);
  for (int i = 0; i < length; i += kBlock<T>) {
    Block<T> sum;
    const T* middle = extended_.data() + i + half;
    sum.add(kernel_[half], middle);
    for (int j = 1; j <= half; ++j) sum.add(kernel_[half + j], middle - j, middle + j);
    sum.store(result_.data() + i);
  }
  std::copy_n(result_.begin(), n, out);
}

template <typename T>
void dewow(const T* x, int n, int half_width, T* out) {
  double sum = 0.0;
  for (int i = 0; i < std::min(n, half_width); ++i) sum += x[i];
  for (int i = 0; i < n; ++i) {
    const int first = i - half_width, last = i + half_width;
    const double enters = last < n ? x[last] : T(0), leaves = first > 0 ? x[first - 1] : T(0);
    sum += enters - leaves;
    out[i] = static_cast<T>(x[i] - sum / (std::min(last, n - 1) - std::max(first, 0) + 1));
  }
}

std::vector<double> gain_curve(int n, double rate, double power, int flat_after) {
  std::vector<double> gain;
  for (int i = 0; i < n; ++i) {
    const double at = std::min(i, std::max(flat_after, 0));
    gain.push_back(std::pow(std::max(at, 1.0), power) * std::exp(rate * at));
  }
  return gain;
}

template class ZeroPhaseFilter<float>;
template class ZeroPhaseFilter<double>;
template void dewow(const float*, int, int, float*);
template void dewow(const double*, int, int, double*);

}  // namespace gprodom::gpr
