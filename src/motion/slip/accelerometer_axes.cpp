#include "motion/slip/accelerometer_axes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom::slip {

namespace {

// Before a drive has shown anything. Few mount an IMU otherwise than they configure it. With 1e-3 a
// large gyro bias, after a start on the move, passes for other axes; with 1e-4 the first
// acceleration of an IMU that is turned by 180 degrees passes for slip (docs/lessons.md).
constexpr double kWrongAtFirst = 3e-4;
// Angles about the up axis at which hypotheses begin, each with and without a mirrored forward
// axis. Their filters are linear in the angle, so they begin this near.
constexpr int kAngles = 8;
constexpr double kBetween = 2 * M_PI / kAngles;
// Of sensitivities and of axes that are not perpendicular; as with cheap accelerometers.
constexpr double kElements = 0.05;
constexpr double kLeast = 1e-9;  // probability; its logarithm is finite

}  // namespace

// Kind 0 is neither turned nor mirrored.
AccelerometerAxes::AccelerometerAxes() : wrong_(kWrongAtFirst) {
  constexpr int kKinds = 2 * kAngles;
  for (int kind = 1; kind < kKinds; ++kind) {
    const double angle = kBetween * (kind % kAngles), forwards = kind < kAngles ? 1.0 : -1.0;
    const double c = std::cos(angle), s = std::sin(angle);
    const Eigen::Vector4d mean(c * forwards - 1, -s, s * forwards, c - 1);
    const Eigen::Vector4d by_angle(-s * forwards, -c, c * forwards, -s);
    constexpr double kVariance = kBetween * kBetween / 12;  // uniform between two angles
    kinds_.push_back({kind, 1.0 / (kKinds - 1), mean,
                      kElements * kElements * Eigen::Matrix4d::Identity() +
                          kVariance * by_angle * by_angle.transpose()});
  }
}

void AccelerometerAxes::branch(std::vector<Hypothesis>& hypotheses) const {
  const Hypothesis as_configured = hypotheses.front();
  hypotheses.front().log_weight += std::log1p(-wrong_);
  for (const Kind& kind : kinds_) {
    Hypothesis h = as_configured;
    h.axes_kind = kind.kind;
    h.log_weight += std::log(wrong_ * kind.share);
    h.x.segment<4>(row::kAxes) = kind.mean;
    h.P.block<4, 4>(row::kAxes, row::kAxes) = kind.covariance;
    hypotheses.push_back(h);
  }
}

// They are in the order of their weights; of each kind the likeliest stands for all.
void AccelerometerAxes::learn(const std::vector<Hypothesis>& hypotheses) {
  std::vector<Kind> kinds;
  double wrong = 0.0;
  for (const Hypothesis& h : hypotheses) {
    if (h.axes_kind == kConfiguredAxes) continue;
    const double weight = std::exp(h.log_weight);
    wrong += weight;
    const auto same = std::find_if(kinds.begin(), kinds.end(),
                                   [&](const Kind& kind) { return kind.kind == h.axes_kind; });
    if (same != kinds.end())
      same->share += weight;
    else
      kinds.push_back({h.axes_kind, weight, h.x.segment<4>(row::kAxes),
                       h.P.block<4, 4>(row::kAxes, row::kAxes)});
  }
  wrong_ = std::clamp(wrong, kLeast, 1 - kLeast);
  if (wrong < kLeast) return;  // the weights may be 0; the shares stay
  for (Kind& kind : kinds) kind.share = std::max(kind.share / wrong, kLeast);
  kinds_ = std::move(kinds);
}

double AccelerometerAxes::error_sigma(const Eigen::Vector2d& acceleration) const {
  double square = 0.0;
  for (const Kind& kind : kinds_) {
    const Eigen::Vector2d error(kind.mean.head<2>().dot(acceleration),
                                kind.mean.tail<2>().dot(acceleration));
    const double spread = acceleration.dot(kind.covariance.topLeftCorner<2, 2>() * acceleration);
    square += kind.share * (error.squaredNorm() + spread);
  }
  return std::sqrt(without_unlikely(wrong_) * square);
}

}  // namespace gprodom::slip
