// What a block's measurements say of a hypothesis: the wheel, the accelerations sideways, a
// standstill.
#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/slip/slip_belief.h"

namespace gprodom {

using slip::Hypothesis;
using slip::kOutlier;
using slip::Vector;
namespace row_of = slip::row;

namespace {

constexpr double kStands_mps = 2e-3;

}  // namespace

// What bias and gravity add to the block's change of speed, along the accelerometer's axes (m/s).
Eigen::Vector2d SlipBelief::errors(const Hypothesis& h) const {
  return block_.dt * h.x.segment<2>(row_of::kAccelBias) +
         block_.by_tilt() * h.x.segment<2>(row_of::kTilt);
}

// Centripetal acceleration: the change of speed to the left is the integral of speed times turn
// rate. The speed is that at the block's end, less what the accelerations have added since.
//
// Bias and tilt are taken out of what they have added, but H has no derivatives of that by bias and
// tilt. weigh_wheel() has none either, and with them here alone a bias learnt in the first turn is
// wrong by 3 sigma (ABiasIsLearntFromTurnsIfGravityShowsThatThereIsSome).
//
// The lasting error of acceleration is left out: with it, an acceleration that is wrong in one bend
// moves the estimated place of the wheel (AccelerationsThatAreWrongInOneBendDoNotMoveTheWheel).
SlipBelief::Measured SlipBelief::sideways(const Hypothesis& h) const {
  const slip::Block& b = block_;
  const Eigen::Matrix2d axes = h.axes();
  const double before = b.dt > 0 ? b.turn_s / b.dt : 0.0;  // mean turn before an acceleration, rad
  const Eigen::Vector2d gained = b.gained - errors(h);
  const Eigen::Vector2d turned_before = b.turned_before - before * errors(h);
  Measured left{Vector::Zero(), 0.0};
  left.H[row_of::kSpeed] = b.turned;
  left.H.segment<2>(row_of::kTilt) = axes.row(1) * b.by_tilt();
  left.H.segment<2>(row_of::kAccelBias) = b.dt * axes.row(1);
  left.H.segment<2>(row_of::kAxes) = -turned_before;
  left.H.segment<2>(row_of::kAxes + 2) = -gained;
  left.residual =
      axes.row(1).dot(gained) + axes.row(0).dot(turned_before) - b.turned * h.x[row_of::kSpeed];
  return left;
}

void SlipBelief::weigh(Hypothesis& h) const {
  const slip::Block& b = block_;
  if (b.standing) {
    weigh_standing(h);
    return;
  }
  if (b.wheel) weigh_wheel(h);
  const Measured left = sideways(h);
  const double density = std::max(b.noise.accel_density, b.noise.sideways_density);
  h.log_weight += h.update(left.H, left.residual, density * density * b.dt, kOutlier);
  // The residuals are in metres and m/s on the ground, the measurement is M^-1 times that, so its
  // density has the factor |M|. Without it, axes that have shrunk explain everything. Of axes that
  // have grown, the noise has grown as much, which takes the factor back.
  constexpr double kLeast = std::numeric_limits<double>::min();  // its logarithm is finite
  h.log_weight += std::log(std::clamp(std::abs(h.axes().determinant()), kLeast, 1.0));
}

void SlipBelief::weigh_standing(Hypothesis& h) const {
  const slip::Block& b = block_;
  Vector H = Vector::Zero();
  H[row_of::kSpeed] = 1;
  h.update(H, -h.x[row_of::kSpeed], kStands_mps * kStands_mps);
  for (int axis = 0; axis < 2; ++axis) {
    H.setZero();
    H[row_of::kGyroBias + axis] = 1;
    h.update(H, b.rates[axis] / b.dt - h.x[row_of::kGyroBias + axis],
             rest_.gyro_density * rest_.gyro_density / b.dt);
  }
  const Measured left = sideways(h);
  h.update(left.H, left.residual, b.noise.accel_density * b.noise.accel_density * b.dt);
}

// In metres on the ground: the wheel's distance is given, the robot's depends on the slip.
void SlipBelief::weigh_wheel(Hypothesis& h) const {
  const slip::Block& b = block_;
  const double dt = b.dt;
  const double stretch = std::exp(h.x[row_of::kSlip] - h.x[row_of::kScale]);
  const double by_wheel = b.wheel_m * stretch;
  const Eigen::RowVector2d forwards = h.axes().row(0);
  Vector H = Vector::Zero();
  H[row_of::kSpeed] = dt;
  H[row_of::kSlip] = -by_wheel;
  H[row_of::kScale] = by_wheel;
  H[row_of::kWheelY] = -b.turned;
  H.segment<2>(row_of::kAxes) = -b.behind_m;
  const double white = wheel_noise_ * wheel_noise_ * std::abs(b.wheel_m);
  const double drawn = 0.33 * b.noise.accel_density * b.noise.accel_density * dt * dt * dt;
  const double variance = std::max(white + wheel_floor_ * wheel_floor_, b.wheel_variance);
  const double behind_m =
      forwards * (b.behind_m - 0.5 * dt * errors(h)) - 0.5 * dt * dt * h.x[row_of::kAccelError];
  const double way =
      h.x[row_of::kSpeed] * dt - behind_m - h.x[row_of::kWheelY] * b.turned;  // of the wheel
  // The wheel's noise is stretched with its distance. The likelihood must not prefer a hypothesis
  // for the size of its noise, which is not known so well; the last term removes that.
  const double known = H.dot(h.P * H) + drawn, stretched = variance * stretch * stretch;
  h.log_weight += h.update(H, by_wheel - way, stretched + drawn, kOutlier) +
                  0.5 * std::log((known + stretched) / (known + variance));
}

}  // namespace gprodom
