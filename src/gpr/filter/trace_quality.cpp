#include "gpr/filter/trace_quality.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {
namespace {

constexpr double kWhite = 1.5;            // mean squared difference of neighbours over mean square
constexpr double kDeadPower = 1.0 / 400;  // of the usual mean square
constexpr double kUnlike = 0.25;          // mean squared difference over the sum of mean squares
constexpr double kDeviations = 3.0;
constexpr double kRate = 1.0 / 16;  // per trace, of the running statistics
constexpr int kSettled = 8;         // traces before the running statistics count
constexpr float kSpike = 0.5f;      // of the largest value

// Largest deviation of a sample from the cubic through its four neighbours.
float largest_deviation(const Eigen::VectorXf& x) {
  const Eigen::Index n = x.size() - 4;
  return (x.segment(2, n) - (2.0f / 3.0f) * (x.segment(1, n) + x.segment(3, n)) +
          (1.0f / 6.0f) * (x.segment(0, n) + x.segment(4, n)))
      .cwiseAbs()
      .maxCoeff();
}

}  // namespace

void TraceCheck::reset() {
  last_.resize(0);
  usual_power_ = log_difference_ = log_deviation_ = 0.0;
  seen_ = spiked_in_a_row_ = 0;
}

bool TraceCheck::is_glitch(double power, double difference) {
  const double both = power + last_.squaredNorm() / static_cast<double>(last_.size());
  const double log_difference = std::log(std::max(difference, 1e-12 * both));
  const bool unlike = difference > kUnlike * both;
  const bool unusual = log_difference > log_difference_ + kDeviations * log_deviation_;
  if (seen_ >= kSettled && unlike && unusual && spiked_in_a_row_ < kMaxSpikedInARow) {
    ++spiked_in_a_row_;
    return true;
  }
  const double rate = std::max(kRate, 1.0 / seen_);  // seen_ - 1 differences before this one
  if (seen_ == 1) log_difference_ = log_difference;
  log_difference_ += rate * (log_difference - log_difference_);
  log_deviation_ += rate * (std::abs(log_difference - log_difference_) - log_deviation_);
  spiked_in_a_row_ = 0;
  return false;
}

TraceQuality TraceCheck::check(const float* samples, int n) {
  const Eigen::Map<const Eigen::VectorXf> raw(samples, n);
  if (trace_.size() != n) {
    reset();
    trace_.resize(n);
  }
  trace_ = raw.array() - raw.mean();
  const double power = trace_.squaredNorm() / n;
  const double steps = (trace_.tail(n - 1) - trace_.head(n - 1)).squaredNorm() / (n - 1);
  if (!(power > 0.0) || steps > kWhite * power || power < kDeadPower * usual_power_) {
    return TraceQuality::kDead;
  }
  if (largest_deviation(trace_) > kSpike * trace_.cwiseAbs().maxCoeff()) {
    return TraceQuality::kSpiked;
  }
  if (last_.size() == n && is_glitch(power, (trace_ - last_).squaredNorm() / n)) {
    return TraceQuality::kSpiked;
  }
  const double rate = std::max(kRate, 1.0 / (seen_ + 1.0));
  usual_power_ += rate * (power - usual_power_);
  last_ = trace_;
  ++seen_;
  return TraceQuality::kGood;
}

}  // namespace gprodom::gpr
