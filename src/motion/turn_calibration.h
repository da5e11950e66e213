// What left and right wheels say of the robot's turning, learnt against the gyro.
//
// Over a stretch on which the body turns by psi and its middle moves by m, right less left is
//   D = B (psi - tau w) + d m + n,
// with B the effective track (of a skid steer wider than the geometric one), d the difference of
// the radii, right over left less one, tau the time by which the wheels come behind the gyro, w the
// change of the turn rate from the stretch's beginning to its end, and n the slip of the two sides.
// A Kalman filter holds B, d and B tau; the variance of n is learnt beside them, per metre that the
// sides go. The gyro is the regressor, since its error is the smaller one: regressed the other way
// round, slip would make the track look wider. What the motion does not show stays as it is.
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
  double path_m = 0.0;        // unsigned, of both sides together

  PairMotion& operator+=(const PairMotion& next) {
    middle_m += next.middle_m;
    difference_m += next.difference_m;
    path_m += next.path_m;
    return *this;
  }
};

// What the gyro, less its bias, has of the same stretch.
struct GyroTurn {
  double rad = 0.0;
  double faster = 0.0;  // rad/s: the rate at its end less that at its beginning

  GyroTurn& operator+=(const GyroTurn& next) {
    rad += next.rad;
    faster += next.faster;
    return *this;
  }
};

// What one run leaves to the next; standard deviations beside the values.
struct LearntTurn {
  double track_m = 0.0, track_sigma_m = 0.0;
  double radii_difference = 0.0, radii_difference_sigma = 0.0;
};

class TurnCalibration {
 public:
  // floor_m: error of one side's distance over any stretch.
  TurnCalibration(const DriveTraits& traits, double floor_m);

  // A stretch of dt_s that follows the one before; turned_rad as the gyro has it, less its bias.
  void learn(const PairMotion& motion, double turned_rad, double dt_s);
  // What an earlier run has learnt, with the room for what has changed since. What it has not
  // learnt better than is known of such a drive at first stays as it is.
  void resume(const LearntTurn& learnt);
  LearntTurn learnt() const;
  // What comes next does not follow what was learnt from last.
  void interrupt();

  // The body's turn (rad) that the wheels tell, and its variance.
  double turn(const PairMotion& motion) const;
  double turn_variance(const PairMotion& motion) const;
  // Of right less left, as the wheels report it, about what is expected where the body turns so.
  double expected_difference(double middle_m, const GyroTurn& turn) const;
  double difference_variance(const PairMotion& motion, const GyroTurn& turn) const;

  double track_m() const { return x_[0]; }
  double track_sigma_m() const { return std::sqrt(P_(0, 0)); }
  double radii_difference() const { return x_[1]; }
  double radii_difference_sigma() const { return std::sqrt(P_(1, 1)); }
  // s; the wheels come behind the gyro.
  double delay_s() const { return x_[2] / x_[0]; }
  double delay_sigma_s() const { return std::sqrt(P_(2, 2)) / x_[0]; }
  // Of D, m/sqrt(m) of the way of both sides together; what the drive lets expect is in it.
  double noise() const;
  // The same by what was seen alone, per metre of the middle's way, which is half of that of both
  // sides; 0 where that is too little yet.
  double noise_seen_by_middle() const;

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
  double noise_sum_ = 0.0, noise_path_m_ = 0.0;  // seen, m^2 over m
  Window window_;
  std::optional<double> rate_;  // rad/s, of the stretch learnt from last
};

}  // namespace gprodom
