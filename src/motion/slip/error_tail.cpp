#include "motion/slip/error_tail.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

// The upper quantile. Up to it, the sample is not changed by slips that begin in less than a tenth
// of the intervals.
constexpr double kUpper = 0.9;

// Intervals that the assumption of normal errors counts for. The median of so many has a relative
// standard deviation of 40 %, and that much is not known about a noise beforehand either.
constexpr int kPrior = 20;
constexpr std::size_t kMostIntervals = 600;  // three minutes of driving

// 2: a normal error, whose standard deviation varies like another one. Beyond, it is slip.
constexpr double kLargestExponent = 2.0;

// Square of a standard normal variable that is exceeded with the probability 1 - part.
double normal_square(double part) {
  double low = 0.0, high = 10.0;  // standard deviations
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (std::erf(middle / std::sqrt(2.0)) < part ? low : high) = middle;
  }
  return low * low;
}

}  // namespace

ErrorTail::ErrorTail() {
  for (int i = 0; i < kPrior; ++i) sorted_.push_back(normal_square((i + 0.5) / kPrior));
}

void ErrorTail::add(double square) {
  if (!std::isfinite(square)) return;
  kept_.push_back(square);
  sorted_.insert(std::upper_bound(sorted_.begin(), sorted_.end(), square), square);
  if (kept_.size() > kMostIntervals) {
    sorted_.erase(std::lower_bound(sorted_.begin(), sorted_.end(), kept_.front()));
    kept_.pop_front();
  }
  fit();
}

// Through the median and the upper quantile.
void ErrorTail::fit() {
  const auto quantile = [this](double part) {
    const double place = part * static_cast<double>(sorted_.size()) - 0.5;
    const auto below = static_cast<std::size_t>(place);
    const double u = place - static_cast<double>(below);
    return (1 - u) * sorted_[below] + u * sorted_[below + 1];
  };
  constexpr double kLeast = 1e-12;  // wheel and IMU that agree exactly have no logarithm
  static const double normal_median = normal_square(0.5), normal_upper = normal_square(kUpper);
  const double median = std::max(quantile(0.5), kLeast), upper = quantile(kUpper);
  exponent_ = std::clamp(std::log(upper / median) / std::log(normal_upper / normal_median), 1.0,
                         kLargestExponent);
  size_ = std::sqrt(upper / std::pow(normal_upper, exponent_));
}

double ErrorTail::threshold(double deviations) const {
  return std::max(deviations, size_ * std::pow(deviations, exponent_));
}

}  // namespace gprodom
