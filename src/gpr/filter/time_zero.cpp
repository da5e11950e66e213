#include "gpr/filter/time_zero.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "gpr/kernels/lanes.h"

namespace gprodom::gpr {
namespace {

constexpr int kTaps = 8;
constexpr int kBefore = kTaps / 2 - 1;  // taps left of the interpolated point's left neighbour
constexpr float kOnset = 0.3f;  // of the largest value; the first extremum above it is the onset
constexpr double kPeriodsBefore = 0.75, kPeriodsAfter = 0.75;  // window around the onset
constexpr double kMemory = 400.0;                              // traces in the reference
constexpr int kIterations = 3;
constexpr float kMinCorrelation = 0.8f;  // of the aligned direct wave with the reference
constexpr int kMaxLost = 100;            // traces in a row before a new reference is taken
constexpr int kRelocate = 16;            // traces until the window's place is final

// Windowed sinc about a point `fraction` (0 <= fraction < 1) right of the tap kBefore.
std::array<float, kTaps> interpolation_taps(double fraction) {
  std::array<float, kTaps> taps{};
  double sum = 0.0;
  std::array<double, kTaps> values{};
  for (int k = 0; k < kTaps; ++k) {
    const double u = k - kBefore - fraction;
    const double sinc = std::abs(u) < 1e-9 ? 1.0 : std::sin(M_PI * u) / (M_PI * u);
    const double window = std::cos(M_PI * u / (kTaps + 1.0));
    values[k] = sinc * window * window;
    sum += values[k];
  }
  for (int k = 0; k < kTaps; ++k) taps[k] = static_cast<float>(values[k] / sum);
  return taps;
}

// out[i] = x(first + i - delay) for `count` samples.
void interpolate(const float* x, int n, double delay, int first, int count, float* out) {
  const double start = first - delay;
  const int whole = static_cast<int>(std::floor(start));
  const std::array<float, kTaps> taps = interpolation_taps(start - whole);
  int i = 0;
  while (i < count) {
    const int from = whole + i - kBefore;  // x index of the first tap
    if (from >= 0 && from + kTaps + kBlock<float> <= n && i + kBlock<float> <= count) {
      Block<float> sum;
      for (int k = 0; k < kTaps; ++k) sum.add(taps[k], x + from + k);
      sum.store(out + i);
      i += kBlock<float>;
    } else {
      float sum = 0.0f;
      for (int k = 0; k < kTaps; ++k) sum += taps[k] * x[std::clamp(from + k, 0, n - 1)];
      out[i++] = sum;
    }
  }
}

}  // namespace

void delay_trace(const float* x, int n, double delay, float* out) {
  if (n > 0) interpolate(x, n, delay, 0, n, out);
}

TimeZeroTracker::TimeZeroTracker(double period, double max_delay)
    : period_(std::max(period, 2.0)), max_delay_(static_cast<int>(std::ceil(max_delay))) {}

void TimeZeroTracker::reset() { reference_.resize(0); }

// Takes the first clear extremum as the direct wave, since later ones may already contain ground.
void TimeZeroTracker::place_window() {
  const int n = static_cast<int>(reference_.size());
  const float limit = kOnset * reference_.cwiseAbs().maxCoeff();
  int peak = 1;
  while (peak < n - 8 && !(std::abs(reference_[peak]) >= limit &&
                           std::abs(reference_[peak]) >= std::abs(reference_[peak + 1]))) {
    ++peak;
  }
  const int last = std::min(n - 1, peak + static_cast<int>(std::lround(kPeriodsAfter * period_)));
  first_ = std::max(1, peak - static_cast<int>(std::lround(kPeriodsBefore * period_)));
  length_ = std::clamp(last - first_, 4, n - 1 - first_);
}

int TimeZeroTracker::best_whole_delay(const float* x, int n) const {
  int best = 0;
  float smallest = std::numeric_limits<float>::max();
  for (int delay = -max_delay_; delay <= max_delay_; ++delay) {
    // Samples before the start of the trace are left out.
    const int skipped = std::max(0, -(first_ + delay));
    const int count = std::min(length_, n - first_ - delay) - skipped;
    if (count < length_ / 2) continue;
    const Eigen::Map<const Eigen::VectorXf> shifted(x + first_ + delay + skipped, count);
    const float misfit =
        (shifted - reference_.segment(first_ + skipped, count)).squaredNorm() / count;
    if (misfit < smallest) {
      smallest = misfit;
      best = delay;
    }
  }
  return best;
}

// Solves g r(i) - d g r'(i) = x(i + delay) for gain g and rest d on the direct wave.
std::optional<double> TimeZeroTracker::refine(const float* x, int n, double delay) {
  const int skipped = std::clamp(static_cast<int>(std::ceil(-(first_ + delay))), 0, length_ / 2);
  const int first = first_ + skipped, length = length_ - skipped;
  const auto r = reference_.segment(first, length);
  const auto slope =
      0.5f * (reference_.segment(first + 1, length) - reference_.segment(first - 1, length));
  const double rr = r.squaredNorm(), ss = slope.squaredNorm(), rs = r.dot(slope);
  const double determinant = rr * ss - rs * rs;
  if (!(determinant > 1e-6 * rr * ss)) return std::nullopt;
  auto moved = moved_.head(length);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    interpolate(x, n, -delay, first, length, moved.data());
    const double rx = r.dot(moved), sx = slope.dot(moved);
    const double gain = (ss * rx - rs * sx) / determinant;
    const double rest = -(rr * sx - rs * rx) / determinant / gain;
    if (!(gain > 0.0) || std::abs(rest) > period_) return std::nullopt;
    delay += rest;
    if (std::abs(rest) < 1e-3) break;
  }
  const float correlation = r.dot(moved) / std::sqrt(static_cast<float>(rr) * moved.squaredNorm());
  if (!(correlation > kMinCorrelation) || std::abs(delay) > max_delay_) return std::nullopt;
  return delay;
}

double TimeZeroTracker::align(const float* x, int n, float* out) {
  if (reference_.size() != n || lost_ >= kMaxLost || !(reference_.squaredNorm() > 0.0f)) {
    reference_.setZero(n);
    moved_.resize(n);
    traces_ = 0.0;
    lost_ = 0;
    delay_ = 0.0;
    std::copy_n(x, n, out);
  } else {
    const std::optional<double> found = refine(x, n, best_whole_delay(x, n));
    delay_ = found.value_or(delay_);
    lost_ = found ? 0 : lost_ + 1;
    delay_trace(x, n, -delay_, out);
    if (!found) return delay_;
  }
  const Eigen::Map<const Eigen::VectorXf> aligned(out, n);
  traces_ = std::min(traces_ + 1.0, kMemory);
  reference_ += static_cast<float>(1.0 / traces_) * (aligned - reference_);
  if (traces_ <= kRelocate) place_window();
  return delay_;
}

}  // namespace gprodom::gpr
