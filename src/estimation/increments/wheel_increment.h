// The wheel's increments between two states, turned by the gyro into a displacement.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gprodom {

// Standard deviation of the distance that a wheel without data, or one that slips, has rolled.
inline constexpr double kUnknownDistanceSigma_m = 100.0;

struct WheelNoise {
  double forward = 0.0;   // m/sqrt(m)
  double lateral = 0.0;   // m/sqrt(m)
  double vertical = 0.0;  // m/sqrt(m)
  double floor = 0.0;     // m, of a whole increment
};

// sum_k R_k e1 d_k over steps of signed wheel distance d_k, R_k the gyro's attitude in the middle
// of step k relative to the start. Wu et al., "VINS on wheels", 2017.
class WheelIncrement {
 public:
  WheelIncrement() = default;
  explicit WheelIncrement(const Eigen::Vector3d& gyro_bias) : gyro_bias_(gyro_bias) {}

  // Rate in body (rad/s) over dt (s), and the signed wheel distance (m) of the same time.
  void integrate(const Eigen::Vector3d& angular_velocity, double dt, double distance_m);

  const Eigen::Vector3d& gyro_bias() const { return gyro_bias_; }
  const Eigen::Vector3d& displacement() const { return displacement_; }  // m, in body at the start
  const Eigen::Matrix3d& d_dbg() const { return d_dbg_; }
  double distance() const { return distance_; }  // signed sum, m
  double path() const { return path_; }          // unsigned sum, m

  // Scales all distances.
  WheelIncrement stretched(double factor) const;

  // Of forward, lateral and vertical displacement, m^2.
  Eigen::Vector3d variance(const WheelNoise& noise) const;

 private:
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d dq_dbg_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d displacement_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d d_dbg_ = Eigen::Matrix3d::Zero();
  double distance_ = 0.0, path_ = 0.0;
};

}  // namespace gprodom
