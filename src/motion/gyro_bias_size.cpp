#include "motion/gyro_bias_size.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace gprodom {

using Eigen::ArrayXd;
using Eigen::Vector3d;

namespace {

struct Measured {
  double bias, sigma;  // rad/s
};

// Means over the parts of the wheel's speeds.
struct Parts {
  std::vector<Vector3d> force, rate;
};

Parts means(const std::vector<ImuSample>& samples, const WheelSpeeds& wheel) {
  const std::size_t n = wheel.mps.size();
  Parts parts{{n, Vector3d::Zero()}, {n, Vector3d::Zero()}};
  std::vector<int> count(n);
  for (const ImuSample& s : samples) {
    const double part = to_seconds(s.time - wheel.from) / WheelSpeeds::kPart;
    if (part < 0 || part >= static_cast<double>(n)) continue;
    const auto k = static_cast<std::size_t>(part);
    parts.force[k] += s.acceleration;
    parts.rate[k] += s.angular_velocity;
    ++count[k];
  }
  for (std::size_t k = 0; k < n; ++k) {
    parts.force[k] /= count[k];  // NaN without a sample
    parts.rate[k] /= count[k];
  }
  return parts;
}

// The slope of the angle that the gyro gives less the one that gravity gives.
Measured slope(const ArrayXd& rate, const ArrayXd& by_gravity) {
  // Errors of neighbouring parts are alike, as a slip or a bump lasts for several of them.
  constexpr double kAlike = 1.5;
  const Eigen::Index n = rate.size();
  ArrayXd error(n), t(n);
  double angle = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    error[k] = angle + 0.5 * rate[k] * WheelSpeeds::kPart - by_gravity[k];
    angle += rate[k] * WheelSpeeds::kPart;
    t[k] = (static_cast<double>(k) - 0.5 * static_cast<double>(n - 1)) * WheelSpeeds::kPart;
  }
  const double spread = t.square().sum();
  const double bias = (t * error).sum() / spread;
  const ArrayXd rest = error - error.mean() - bias * t;
  const double variance = rest.square().sum() / static_cast<double>(n - 2) / spread;
  return {bias, kAlike * std::sqrt(variance)};
}

}  // namespace

GyroBiasSize gyro_bias_size(const std::vector<ImuSample>& samples, const WheelSpeeds& wheel) {
  constexpr std::size_t kFewest = 10;  // parts
  const std::size_t n = wheel.mps.size();
  if (n < kFewest) return {};
  const Parts parts = means(samples, wheel);
  const auto size = static_cast<Eigen::Index>(n);
  ArrayXd roll(size), pitch(size), roll_rate(size), pitch_rate(size);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t before = k > 0 ? k - 1 : 0, after = std::min(k + 1, n - 1);
    const double seconds = static_cast<double>(after - before) * WheelSpeeds::kPart;
    const double speedup = (wheel.mps[after] - wheel.mps[before]) / seconds;
    const Vector3d& w = parts.rate[k];
    const auto i = static_cast<Eigen::Index>(k);
    roll[i] = (parts.force[k].y() - w.z() * wheel.mps[k]) / kStandardGravity;
    pitch[i] = -(parts.force[k].x() - speedup) / kStandardGravity;
    // A turn on sloping ground changes roll into pitch.
    roll_rate[i] = w.x() + w.z() * pitch[i];
    pitch_rate[i] = w.y() - w.z() * roll[i];
  }
  // The variance starts as that of a good MEMS gyro, with the weight of two axes. Expectation
  // maximisation: the mean square of each bias, given the variance, makes the next variance.
  constexpr double kWeight = 2.0, kUsual2 = kUsualGyroBias * kUsualGyroBias;
  constexpr int kIterations = 50;
  const Measured x = slope(roll_rate, roll), y = slope(pitch_rate, pitch);
  double size2 = kUsual2;
  for (int i = 0; i < kIterations; ++i) {
    double sum = kWeight * kUsual2;
    for (const Measured& axis : {x, y}) {
      const double share = size2 / (size2 + axis.sigma * axis.sigma);
      sum += std::pow(share * axis.bias, 2) + share * axis.sigma * axis.sigma;
    }
    size2 = sum / (kWeight + 2);
  }
  // Beyond what a gyro may be off by, it is the accelerations that are wrong, and tell nothing.
  if (!(size2 < kMaxGyroBias * kMaxGyroBias)) return {};
  return {std::sqrt(std::max(size2, kUsual2)), std::min(x.sigma, y.sigma) < 2 * kUsualGyroBias};
}

}  // namespace gprodom
