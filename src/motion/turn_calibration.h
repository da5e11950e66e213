// The robot's turn from left and right wheels, calibrated against the gyro.
//
// Over a stretch on which the body turns by psi and its middle moves by m, right less left is
//   D = B (psi - tau w) + d m + n,
// with B the effective track (wider than the geometric one on a skid steer), d the difference of
// the radii (right over left, less one), tau the delay of the wheels against the gyro, w the change
// of the turn rate from the stretch's beginning to its end, and n the slip of the two sides. A
// Kalman filter estimates B, d and B tau. The variance of n per metre of both sides is learnt with
// them. The gyro is the regressor, since its error is the smaller one: the other way round, slip
// would bias the track towards larger values. What the motion does not excite keeps its value.
// docs/estimation.md, "Two wheels".
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "estimation/drive_traits.h"

namespace gprodom {

// What the wheels report over a stretch.
struct PairMotion {
  double middle_m = 0.0;      // mean of left and right, signed
  double difference_m = 0.0;  // right less left
  double path_m = 0.0;        // unsigned, sum of both sides

  PairMotion& operator+=(const PairMotion& next) {
    middle_m += next.middle_m;
    difference_m += next.difference_m;
    path_m += next.path_m;
    return *this;
  }
};

// What the gyro, less its bias, measures over the same stretch.
struct GyroTurn {
  double rad = 0.0;
  double rate_change = 0.0;  // rad/s: the rate at its end less that at its beginning

  GyroTurn& operator+=(const GyroTurn& next) {
    rad += next.rad;
    rate_change += next.rate_change;
    return *this;
  }
};

// What is saved for the next run; standard deviations beside the values.
struct LearntTurn {
  double track_m = 0.0, track_sigma_m = 0.0;
  double radii_difference = 0.0, radii_difference_sigma = 0.0;
};

class TurnCalibration {
 public:
  // floor_m: error of one side's distance over any stretch.
  TurnCalibration(const DriveTraits& traits, double floor_m);

  // The difference has such an error of two sides at two ends.
  void set_floor(double floor_m) { floor_variance_ = 4 * floor_m * floor_m; }

  // A stretch of dt_s that follows the last one; turned_rad by the gyro, less its bias.
  void learn(const PairMotion& motion, double turned_rad, double dt_s);
  // Takes over what an earlier run has learnt, with a variance for changes since then. A value less
  // certain than the prior of such a drive is not taken over.
  void resume(const LearntTurn& learnt);
  LearntTurn learnt() const;
  // The next stretch does not follow the last one.
  void interrupt();

  // The body's turn (rad) by the wheels, and its variance.
  double turn(const PairMotion& motion) const;
  double turn_variance(const PairMotion& motion) const;
  // Right less left, as the wheels report it, that is expected for a turn; and its variance.
  double expected_difference(double middle_m, const GyroTurn& turn) const;
  double difference_variance(const PairMotion& motion, const GyroTurn& turn) const;

  double track_m() const { return x_[0]; }
  double track_sigma_m() const { return std::sqrt(P_(0, 0)); }
  double radii_difference() const { return x_[1]; }
  double radii_difference_sigma() const { return std::sqrt(P_(1, 1)); }
  // s; the delay of the wheels against the gyro.
  double delay_s() const { return x_[2] / x_[0]; }
  double delay_sigma_s() const { return std::sqrt(P_(2, 2)) / x_[0]; }
  // Noise of D, m/sqrt(m) of the path of both sides together; includes the prior of the drive.
  double noise() const;
  // The same without the prior, per metre of the middle's path, which is half of that of both
  // sides; 0 while there is too little data.
  double measured_noise_per_middle() const;

 private:
  struct Window {
    PairMotion motion;
    GyroTurn turn;
    double seconds = 0.0;
  };

  double slip_variance(double path_m) const;
  void update(const Window& window);

  DriveTraits traits_;
  double floor_variance_;  // of a difference, m^2
  Eigen::Vector3d x_;      // B (m), d, B tau (m s)
  Eigen::Matrix3d P_;
  double noise_sum_ = 0.0, noise_path_m_ = 0.0;  // measured, m^2 over m
  Window window_;
  std::optional<double> rate_;  // rad/s, of the last stretch
};

}  // namespace gprodom
