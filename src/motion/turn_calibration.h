// What left and right wheels say of the robot's turning, learnt against the gyro.
//
// Over a stretch on which the body turns by psi and its middle moves by m, right less left is
//   D = B psi + d m + n,
// with B the effective track (of a skid steer wider than the geometric one), d the difference of
// the radii, right over left less one, and n the slip of the two sides. A Kalman filter holds B and
// d; the variance of n is learnt beside them, per metre that the sides go. The gyro is the
// regressor, since its error is the smaller one: regressed the other way round, slip would make the
// track look wider. What the motion does not show stays as it is. docs/estimation.md, "Two wheels".
#pragma once

#include <Eigen/Core>
#include <cmath>

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

class TurnCalibration {
 public:
  // floor_m: error of one side's distance over any stretch.
  TurnCalibration(const DriveTraits& traits, double floor_m);

  // A stretch of dt_s that follows the one before; turned_rad as the gyro has it, less its bias.
  void learn(const PairMotion& motion, double turned_rad, double dt_s);
  // What comes next does not follow what was learnt from last.
  void interrupt() { window_ = {}; }

  // The body's turn (rad) that the wheels tell, and its variance.
  double turn(const PairMotion& motion) const;
  double turn_variance(const PairMotion& motion) const;
  // Of right less left, as the wheels report it, about what is expected where the body turns so.
  double expected_difference(double middle_m, double turned_rad) const;
  double difference_variance(const PairMotion& motion, double turned_rad) const;

  double track_m() const { return x_[0]; }
  double track_sigma_m() const { return std::sqrt(P_(0, 0)); }
  double radii_difference() const { return x_[1]; }
  double radii_difference_sigma() const { return std::sqrt(P_(1, 1)); }
  // Of D, m/sqrt(m) of the way of both sides together; what the drive lets expect is in it.
  double noise() const;
  // The same by what was seen alone, per metre of the middle's way, which is half of that of both
  // sides; 0 where that is too little yet.
  double noise_seen_by_middle() const;

 private:
  struct Window {
    PairMotion motion;
    double turned_rad = 0.0, seconds = 0.0;
  };

  double slip_variance(double path_m) const;
  void update(const Window& window);

  DriveTraits traits_;
  double floor_variance_;  // of a difference, m^2
  Eigen::Vector2d x_;      // B (m), d
  Eigen::Matrix2d P_;
  double noise_sum_ = 0.0, noise_path_m_ = 0.0;  // seen, m^2 over m
  Window window_;
};

}  // namespace gprodom
