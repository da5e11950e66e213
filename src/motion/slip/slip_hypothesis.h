// One account of how a wheel has slipped so far, with a Kalman filter of what follows from it.
// docs/estimation.md, "Slip as it goes".
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

namespace gprodom::slip {

// A wheel grips; or its slip is setting in, growing or ending; or it slips evenly.
enum class Mode { kGrips, kChanges, kHolds };

// Rows of a hypothesis' error: speed (m/s); the leak of gravity into horizontal accelerations, in
// the axes of the world (rad, two rows); biases of accelerometer (m/s^2, x and y of body) and gyro
// (rad/s, x and y); ln of the wheel's scale over what it is taken for; slip l = ln(true distance /
// distance by the wheel at that scale); ln of metres per decorrelation length: what is common to
// the ground, and what is of this place.
namespace row {
constexpr int kSpeed = 0, kTilt = 1, kAccelBias = 3, kGyroBias = 5, kScale = 7, kSlip = 8,
              kGround = 9, kPlace = 10;
}  // namespace row
constexpr int kDim = 11;
using Vector = Eigen::Matrix<double, kDim, 1>;
using Matrix = Eigen::Matrix<double, kDim, kDim>;

// What is believed of l in an interval that has passed.
struct Past {
  double l = 0.0, variance = 0.0;
  double slips = 0.0;  // probability
};

struct Hypothesis {
  Mode mode = Mode::kGrips;
  double log_weight = 0.0;
  Vector x = Vector::Zero();
  Matrix P = Matrix::Zero();
  std::deque<Past> past;  // of the last intervals, newest last

  // residual = what was measured less what x foretells, H its derivative by x. Returns the log of
  // its likelihood, but for what is the same in all hypotheses. `most`: standard deviations; a
  // residual beyond counts as one of that many. 0: as it is.
  double update(const Vector& H, double residual, double variance, double most = 0.0);
};

// Hypotheses that have come to mean the same are made one; of the others the likeliest `most` are
// kept, the likeliest first, with weights that sum to 1.
void prune(std::vector<Hypothesis>& hypotheses, std::size_t most);

}  // namespace gprodom::slip
