#include "motion/slip/wheel_position.h"

#include <cmath>

#include "motion/slip/slip_hypothesis.h"

namespace gprodom::slip {

namespace {

// m, one standard deviation before anything is known: cars and large robots are up to two metres
// wide, and a single wheel may be on either side.
constexpr double kPriorSigma = 0.5;
// That the wheel is where it is configured, to some centimetres. Most users measure it. Between 0.5
// and 0.85 a car with its wheel elsewhere differs by 3 %.
constexpr double kAsConfigured = 0.8, kMeasured = 0.05;
constexpr double kBetweenRuns = 0.02;  // m; the IMU or the wheel was taken off and put back

}  // namespace

WheelPosition::WheelPosition(const WheelConfig& config)
    : configured_m_(config.lever_arm.y()),
      prior_sigma_m_(config.drive == WheelDrive::kSingle ? kPriorSigma : 0.0),
      learnt_{configured_m_, prior_sigma_m_} {}

void WheelPosition::learn(double y_m, double sigma_m) {
  if (learns()) learnt_ = {y_m, sigma_m};
}

void WheelPosition::resume(const LearntPosition& earlier) {
  const double sigma_m = std::hypot(earlier.sigma_m, kBetweenRuns);
  if (learns() && earlier.sigma_m > 0 && sigma_m < prior_sigma_m_) learnt_ = {earlier.y_m, sigma_m};
}

// Two models: the wheel is where it is configured, as well as users measure, or anywhere (the
// prior). Each is weighed with the density that it gives to the learnt offset.
double WheelPosition::believed_m() const {
  if (!learns() || learnt_.sigma_m <= 0) return learnt_.y_m;
  const double offset_m = learnt_.y_m - configured_m_;
  const auto density = [&](double prior_m) {
    const double sigma_m = std::hypot(learnt_.sigma_m, prior_m), sigmas = offset_m / sigma_m;
    return std::exp(-0.5 * sigmas * sigmas) / sigma_m;
  };
  const double elsewhere = (1 - kAsConfigured) * density(prior_sigma_m_),
               there = kAsConfigured * density(kMeasured);
  return configured_m_ + without_unlikely(elsewhere / (elsewhere + there)) * offset_m;
}

}  // namespace gprodom::slip
