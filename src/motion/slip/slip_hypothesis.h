// One hypothesis of how a wheel has slipped so far, with the Kalman filter that belongs to it.
// docs/estimation.md, "Online slip estimation".
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

namespace gprodom::slip {

// The wheel grips; its slip changes (begins, grows or ends); its slip holds.
enum class Mode { kGrips, kChanges, kHolds };

// Rows of a hypothesis' error: speed (m/s); the leak of gravity into horizontal accelerations, in
// the axes of the world (rad, two rows); biases of accelerometer (m/s^2, x and y of body) and gyro
// (rad/s, x and y); ln of the wheel's scale over its nominal value; slip l = ln(true distance /
// distance by the wheel at that scale); ln of metres per decorrelation length: the part common to
// the ground, and the part of this place; the lateral position of the wheel (m, y of body); the
// 2x2 matrix that takes horizontal accelerations from the accelerometer's axes to the body's, less
// the identity (four rows: by rows of the matrix); the error of the acceleration along the way that
// lasts for seconds (m/s^2).
namespace row {
constexpr int kSpeed = 0, kTilt = 1, kAccelBias = 3, kGyroBias = 5, kScale = 7, kSlip = 8,
              kGround = 9, kPlace = 10, kWheelY = 11, kAxes = 12, kAccelError = 16;
}  // namespace row
constexpr int kDim = 17;
using Vector = Eigen::Matrix<double, kDim, 1>;
using Matrix = Eigen::Matrix<double, kDim, kDim>;

// Estimate of l in a past interval.
struct Past {
  double l = 0.0, variance = 0.0;
  double slips = 0.0;  // probability
};

// Bound of a residual that may be an outlier, in standard deviations.
constexpr double kOutlier = 3.0;

// Number of the axes that are configured for the accelerometer; others are numbered from 1.
constexpr int kConfiguredAxes = 0;

struct Hypothesis {
  Mode mode = Mode::kGrips;
  int axes_kind = kConfiguredAxes;  // at the beginning, of AccelerometerAxes
  double log_weight = 0.0;
  Vector x = Vector::Zero();
  Matrix P = Matrix::Zero();
  std::deque<Past> past;  // of the last intervals, newest last

  // residual: measurement less its prediction from x; H: derivative of the prediction by x. Returns
  // the log likelihood without terms that are the same in all hypotheses. `most`: bound of the
  // residual in standard deviations, for outliers; 0: none.
  double update(const Vector& H, double residual, double variance, double most = 0.0);

  // Takes horizontal accelerations along the accelerometer's axes to those of the body.
  Eigen::Matrix2d axes() const;

  // Replaces the slip by another, independent of the rest.
  void set_slip(double l, double sigma);
};

// Share of an effect of probability p that the estimate takes in. What is unlikely belongs to the
// tails, which the factor's robust loss covers.
inline double without_unlikely(double p) { return p * p / (p * p + (1 - p) * (1 - p)); }

// Merges hypotheses that have become alike, and keeps the `most` likeliest of those whose axes are
// as configured, and `most` of the others; of either at least one. The rest are merged into those
// of their mode and axes with the nearest slip. In the order of their weights, which then sum to 1.
void prune(std::vector<Hypothesis>& hypotheses, std::size_t most);

}  // namespace gprodom::slip
