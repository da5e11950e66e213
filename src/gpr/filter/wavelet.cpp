#include "gpr/filter/wavelet.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/require.h"
#include "gpr/kernels/lanes.h"

namespace gprodom::gpr {

template <typename T>
StationaryWavelet<T>::StationaryWavelet(const Wavelet& wavelet, int levels)
    : levels_(levels),
      low_(wavelet.low.begin(), wavelet.low.end()),
      high_(wavelet.high.begin(), wavelet.high.end()) {
  require(levels >= 1 && levels <= 16 && !low_.empty() && low_.size() % 2 == 0 &&
              low_.size() == high_.size(),
          "wavelet transform: expected 1 to 16 levels and even filters");
}

template <typename T>
int StationaryWavelet<T>::padded(int n) const {
  const int unit = 1 << levels_;
  return (n + unit - 1) / unit * unit;
}

template <typename T>
void StationaryWavelet<T>::check(int n) const {
  if (n < 1 || n % (1 << levels_) != 0) {
    throw std::invalid_argument("wavelet transform: " + std::to_string(n) +
                                " samples; expected a multiple of " + std::to_string(1 << levels_));
  }
}

template <typename T>
void StationaryWavelet<T>::extend(const T* x, int n, int left, int right,
                                  std::vector<T>& out) const {
  const std::size_t size = left + blocked<T>(n) + right;
  if (out.size() < size) out.resize(size);  // what blocks read beyond n is never used
  std::copy_n(x, n, out.data() + left);
  for (int i = left - 1; i >= 0; --i) out[i] = out[i + n];
  for (int i = 0; i < right; ++i) out[left + n + i] = out[left + i];
}

template <typename T>
void StationaryWavelet<T>::forward(const T* x, int n, T* details, T* approximation) {
  check(n);
  const int taps = static_cast<int>(low_.size());
  const T* input = x;
  low_out_.resize(blocked<T>(n));
  high_out_.resize(blocked<T>(n));
  for (int level = 0; level < levels_; ++level) {
    const bool smooth = level < levels_ - 1 || approximation != nullptr;
    const int step = 1 << level;
    const int left = (taps / 2 - 1) * step, right = taps / 2 * step;
    extend(input, n, left, right, extended_);
    for (int i = 0; i < n; i += kBlock<T>) {
      const T* source = extended_.data() + left + right + i;
      Block<T> low, high;
      for (int j = 0; j < taps; ++j) high.add(high_[j], source - j * step);
      high.store(high_out_.data() + i);
      if (!smooth) continue;
      for (int j = 0; j < taps; ++j) low.add(low_[j], source - j * step);
      low.store(low_out_.data() + i);
    }
    std::copy_n(high_out_.data(), n, details + level * n);
    input = low_out_.data();
  }
  if (approximation != nullptr) std::copy_n(low_out_.data(), n, approximation);
}

template <typename T>
void StationaryWavelet<T>::inverse(const T* details, const T* approximation, int n, T* x) {
  check(n);
  const int taps = static_cast<int>(low_.size());
  const T* input = approximation;
  low_out_.resize(blocked<T>(n));
  for (int level = levels_ - 1; level >= 0; --level) {
    const int step = 1 << level;
    const int left = taps / 2 * step, right = (taps / 2 - 1) * step;
    if (input != nullptr) extend(input, n, left, right, extended_);
    extend(details + level * n, n, left, right, extended_details_);
    for (int i = 0; i < n; i += kBlock<T>) {
      Block<T> sum;
      const T* detail = extended_details_.data() + i;
      for (int j = 0; j < taps; ++j) sum.add(T(0.5) * high_[j], detail + j * step);
      if (input != nullptr) {
        const T* smooth = extended_.data() + i;
        for (int j = 0; j < taps; ++j) sum.add(T(0.5) * low_[j], smooth + j * step);
      }
      sum.store(low_out_.data() + i);
    }
    input = low_out_.data();
  }
  std::copy_n(low_out_.data(), n, x);
}

template <typename T>
using Values = Eigen::Map<Eigen::Array<T, Eigen::Dynamic, 1>>;

template <typename T>
void soft_threshold(T* values, int n, T threshold) {
  Values<T> v(values, n);
  v -= v.max(-threshold).min(threshold);
}

namespace {

constexpr int kHalvings = 8;

template <typename T>
int count_up_to(const T* values, int n, T limit) {
  using Vector = typename Lane<T>::Type;
  const Vector limits = Vector{} + limit;
  decltype(Vector{} < limits) counts{};
  int i = 0, count = 0;
  for (; i + Lane<T>::kSize <= n; i += Lane<T>::kSize) {
    Vector v;
    std::memcpy(&v, values + i, sizeof(v));
    counts -= v <= limits;
  }
  for (int k = 0; k < Lane<T>::kSize; ++k) count += static_cast<int>(counts[k]);
  for (; i < n; ++i) count += values[i] <= limit ? 1 : 0;
  return count;
}

// The k-th smallest (from 0) of n non-negative values, the largest of which is given. Brackets it
// by counting, which has no unpredictable branches, and selects among the few values that are left.
// Takes a third of the time of std::nth_element over all.
template <typename T>
T kth_smallest(const T* values, int n, int k, T greatest, T* bracketed) {
  T low = T(-1), high = greatest;  // low < the k-th smallest <= high
  for (int i = 0; i < kHalvings; ++i) {
    const T middle = T(0.5) * (std::max(low, T(0)) + high);
    (count_up_to(values, n, middle) > k ? high : low) = middle;
  }
  const int below = count_up_to(values, n, low);
  int count = 0;
  for (int i = 0; i < n; ++i) {
    bracketed[count] = values[i];
    count += static_cast<int>(values[i] > low) & static_cast<int>(values[i] <= high);
  }
  if (k - below >= count) return greatest;  // not all are numbers
  T* kth = bracketed + (k - below);
  std::nth_element(bracketed, kth, bracketed + count);
  return *kth;
}

}  // namespace

template <typename T>
T noise_sigma(const T* values, int n, T* scratch) {
  if (n < 1) return T(0);
  Values<T> size(scratch, n);
  size = Eigen::Map<const Eigen::Array<T, Eigen::Dynamic, 1>>(values, n).abs();
  const T greatest = size.maxCoeff();
  const auto kth = [&](int k) { return kth_smallest(scratch, n, k, greatest, scratch + n); };
  const T median = n % 2 == 0 ? T(0.5) * (kth(n / 2 - 1) + kth(n / 2)) : kth(n / 2);
  return median / T(0.6745);
}

template <typename T>
DetailDenoiser<T>::DetailDenoiser(const Wavelet& wavelet, int levels, double threshold)
    : transform_(wavelet, levels), threshold_(static_cast<T>(threshold)) {}

template <typename T>
T DetailDenoiser<T>::apply(const T* x, int n, T* out) {
  const int length = transform_.padded(n);
  padded_.resize(length);
  details_.resize(static_cast<std::size_t>(length) * transform_.levels());
  scratch_.resize(2 * static_cast<std::size_t>(length));
  std::copy_n(x, n, padded_.data());
  for (int i = n; i < length; ++i) padded_[i] = padded_[std::max(0, 2 * n - 1 - i)];
  transform_.forward(padded_.data(), length, details_.data(), nullptr);
  const T sigma = noise_sigma(details_.data(), n, scratch_.data());
  const T limit = threshold_ * sigma * std::sqrt(T(2) * std::log(static_cast<T>(n)));
  soft_threshold(details_.data(), static_cast<int>(details_.size()), limit);
  transform_.inverse(details_.data(), nullptr, length, padded_.data());
  std::copy_n(padded_.data(), n, out);
  return sigma;
}

template class StationaryWavelet<float>;
template class StationaryWavelet<double>;
template void soft_threshold(float*, int, float);
template void soft_threshold(double*, int, double);
template float noise_sigma(const float*, int, float*);
template double noise_sigma(const double*, int, double*);
template class DetailDenoiser<float>;
template class DetailDenoiser<double>;

}  // namespace gprodom::gpr
