#include "motion/turn_calibration.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

// Slip lasts for about a second. From window to window of this length it is independent, so its
// variance grows with the path.
constexpr double kWindow_s = 2.0;
constexpr double kRadiiSigma = 0.02;  // of tyres of one kind
constexpr double kRadiiWalk = 1e-4;   // 1/sqrt(m): load and pressure
constexpr double kRadiiBetweenRuns = 1e-3;
constexpr double kDelaySigma_s = 0.2;     // of drivers that send a few times a second
constexpr double kPriorPath_m = 3.0;      // of both sides, that the prior of the noise counts for
constexpr double kEnoughPath_m = 20.0;    // likewise; beyond, the noise is known without the prior
constexpr double kNoiseMemory_m = 200.0;  // of both sides
// Standard deviations beyond which a window gets less weight: a side that spins does not show the
// usual slip.
constexpr double kRobust = 3.0;

}  // namespace

TurnCalibration::TurnCalibration(const DriveTraits& traits, double floor_m)
    : traits_(traits), x_(traits.track_m, 0.0, 0.0) {
  set_floor(floor_m);
  P_ = Eigen::Vector3d(traits.track_sigma_m, kRadiiSigma, traits.track_m * kDelaySigma_s)
           .cwiseAbs2()
           .asDiagonal();
}

void TurnCalibration::learn(const PairMotion& motion, double turned_rad, double dt_s) {
  const double rate = turned_rad / dt_s;
  window_.turn += {turned_rad, rate - rate_.value_or(rate)};
  rate_ = rate;
  window_.motion += motion;
  window_.seconds += dt_s;
  if (window_.seconds < kWindow_s) return;
  update(window_);
  window_ = {};
}

void TurnCalibration::resume(const LearntTurn& learnt) {
  const double track_sigma = std::hypot(learnt.track_sigma_m, traits_.track_between_runs_m);
  if (track_sigma < track_sigma_m()) {
    x_[0] = learnt.track_m;
    P_(0, 0) = track_sigma * track_sigma;
  }
  const double radii_sigma = std::hypot(learnt.radii_difference_sigma, kRadiiBetweenRuns);
  if (radii_sigma < radii_difference_sigma()) {
    x_[1] = learnt.radii_difference;
    P_(1, 1) = radii_sigma * radii_sigma;
  }
}

LearntTurn TurnCalibration::learnt() const {
  return {track_m(), track_sigma_m(), radii_difference(), radii_difference_sigma()};
}

void TurnCalibration::interrupt() {
  window_ = {};
  rate_.reset();
}

void TurnCalibration::update(const Window& window) {
  const double path = window.motion.path_m;
  if (path * path < floor_variance_) return;  // standing
  P_(0, 0) += traits_.track_walk_m * traits_.track_walk_m * path;
  P_(1, 1) += kRadiiWalk * kRadiiWalk * path;
  const Eigen::Vector3d h(window.turn.rad, window.motion.middle_m, -window.turn.rate_change);
  const double error = window.motion.difference_m - h.dot(x_);
  const double slip = slip_variance(path), known = h.dot(P_ * h);
  const double deviation2 = error * error / (known + slip);
  const double weight = std::min(1.0, kRobust / std::sqrt(std::max(deviation2, 1e-12)));

  // Posterior mean of the squared slip, which is only a part of the error.
  const double share = slip / (known + slip);
  const double bounded = std::min(error * error, kRobust * kRobust * (known + slip));
  const double slipped2 = share * share * bounded + share * known;
  noise_sum_ += std::max(0.0, slipped2 - floor_variance_);
  noise_path_m_ += path;
  if (noise_path_m_ > kNoiseMemory_m) {
    noise_sum_ *= kNoiseMemory_m / noise_path_m_;
    noise_path_m_ = kNoiseMemory_m;
  }

  const Eigen::Vector3d gain = P_ * h / (known + slip / weight);
  x_ += gain * error;
  const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - gain * h.transpose();
  P_ = (left * P_ * left.transpose() + slip / weight * gain * gain.transpose()).eval();
}

double TurnCalibration::slip_variance(double path_m) const {
  return noise() * noise() * path_m + floor_variance_;
}

double TurnCalibration::noise() const {
  const double expected = traits_.difference_noise_m * traits_.difference_noise_m * kPriorPath_m;
  return std::sqrt((expected + noise_sum_) / (kPriorPath_m + noise_path_m_));
}

double TurnCalibration::measured_noise_per_middle() const {
  return noise_path_m_ < kEnoughPath_m ? 0.0 : std::sqrt(2.0 * noise_sum_ / noise_path_m_);
}

double TurnCalibration::turn(const PairMotion& motion) const {
  return (motion.difference_m - x_[1] * motion.middle_m) / x_[0];
}

double TurnCalibration::turn_variance(const PairMotion& motion) const {
  return difference_variance(motion, {turn(motion), 0.0}) / (x_[0] * x_[0]);
}

double TurnCalibration::expected_difference(double middle_m, const GyroTurn& turn) const {
  return x_.dot(Eigen::Vector3d(turn.rad, middle_m, -turn.rate_change));
}

double TurnCalibration::difference_variance(const PairMotion& motion, const GyroTurn& turn) const {
  const Eigen::Vector3d h(turn.rad, motion.middle_m, -turn.rate_change);
  return h.dot(P_ * h) + slip_variance(motion.path_m);
}

}  // namespace gprodom
