#include "motion/slip/wheel_position.h"

#include <algorithm>
#include <cmath>

namespace gprodom::slip {

namespace {

// m, one standard deviation before anything is known: cars and large robots are up to two metres
// wide, and a single wheel may be on either side.
constexpr double kPriorSigma_m = 0.5;
// That the wheel is where it is configured. Most users measure it. Between 0.5 and 0.85 a car with
// its wheel elsewhere differs by 3 %.
constexpr double kAsConfigured = 0.8;
// m, one standard deviation of the IMU's lateral place. Bends show the place of the wheel less that
// of the IMU, never one of them alone, so a prior must tell which one is not where it is
// configured. Between 0.1 and 0.2 real robots differ by 0.3 %.
constexpr double kImuAside = 0.1;
constexpr double kBetweenRuns = 0.02;  // m; the IMU or the wheel was taken off and put back

}  // namespace

WheelPosition::WheelPosition(const WheelConfig& config)
    : configured_m_(config.lever_arm.y()),
      prior_sigma_m_(config.drive == WheelDrive::kSingle ? kPriorSigma_m : 0.0),
      learnt_{configured_m_, prior_sigma_m_} {}

void WheelPosition::learn(const std::vector<Hypothesis>& hypotheses) {
  if (!learns()) return;
  double mean = 0.0, square = 0.0;
  for (const Hypothesis& h : hypotheses) {
    const double y = h.x[row::kWheelY], weight = std::exp(h.log_weight);
    mean += weight * y;
    square += weight * (y * y + h.P(row::kWheelY, row::kWheelY));
  }
  learnt_ = {mean, std::sqrt(std::max(0.0, square - mean * mean))};
}

void WheelPosition::resume(const LearntPosition& earlier) {
  const double sigma_m = std::hypot(earlier.sigma_m, kBetweenRuns);
  if (learns() && earlier.sigma_m > 0 && sigma_m < prior_sigma_m_) learnt_ = {earlier.y_m, sigma_m};
}

// Two models: the wheel is where it is configured and the offset is the IMU's, or the wheel is
// anywhere (the prior). The bends say N(offset, variance); a model of width w says of that
// N(offset; 0, variance + w^2).
double WheelPosition::believed_m() const {
  if (!learns() || learnt_.sigma_m <= 0) return learnt_.y_m;
  const double learnt_m = learnt_.y_m - configured_m_;
  const double posterior = learnt_.sigma_m * learnt_.sigma_m,
               prior = prior_sigma_m_ * prior_sigma_m_;
  if (posterior >= prior) return configured_m_;
  // Without the prior, which the posterior contains.
  const double variance = posterior * prior / (prior - posterior);
  const double offset_m = learnt_m * prior / (prior - posterior);
  const auto log_density = [&](double width_m) {
    const double total = variance + width_m * width_m;
    return -0.5 * (offset_m * offset_m / total + std::log(total));
  };
  const double ratio = std::exp(log_density(kImuAside) - log_density(prior_sigma_m_));
  const double elsewhere = 1 / (1 + ratio * kAsConfigured / (1 - kAsConfigured));
  return configured_m_ + without_unlikely(elsewhere) * learnt_m;
}

}  // namespace gprodom::slip
