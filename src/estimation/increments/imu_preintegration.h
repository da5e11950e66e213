// Preintegration of the IMU samples between two states: relative rotation, velocity and position,
// with covariance and bias Jacobians. Forster et al., T-RO 2017; docs/estimation.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gprodom {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

struct ImuNoise {
  double gyro_density = 0.0;   // rad/s/sqrt(Hz)
  double accel_density = 0.0;  // m/s^2/sqrt(Hz)
  // Of the lateral acceleration (body y), if it is larger.
  double sideways_density = 0.0;
};

// Rate and specific force are taken as constant in the turning body over each step, and integrated
// exactly under that assumption (GTSAM's manifold form turns the force with the attitude at the
// step's start, which differs by half the step's rotation).
class ImuPreintegration {
 public:
  ImuPreintegration() = default;
  ImuPreintegration(const ImuNoise& noise, const Eigen::Vector3d& gyro_bias,
                    const Eigen::Vector3d& accel_bias);

  // One step: specific force (m/s^2) and rate (rad/s) in body, over dt > 0 seconds.
  void integrate(const Eigen::Vector3d& acceleration, const Eigen::Vector3d& angular_velocity,
                 double dt) {
    integrate(acceleration, angular_velocity, dt, noise_);
  }
  // The same with its own noise, for a sample that is worse than the others.
  void integrate(const Eigen::Vector3d& acceleration, const Eigen::Vector3d& angular_velocity,
                 double dt, const ImuNoise& noise);

  double duration() const { return duration_; }
  const Eigen::Vector3d& gyro_bias() const { return gyro_bias_; }
  const Eigen::Vector3d& accel_bias() const { return accel_bias_; }

  // Relative motion at the biases given, corrected to first order from those integrated with.
  struct Delta {
    Eigen::Quaterniond q;  // body j to body i
    Eigen::Vector3d v, p;  // in body i, gravity not taken out
  };
  Delta delta(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accel_bias) const;
  Delta delta() const { return {q_, v_, p_}; }

  // Order: rotation (right perturbation of q), velocity, position.
  const Matrix9d& covariance() const { return covariance_; }

  const Eigen::Matrix3d& dq_dbg() const { return dq_dbg_; }
  const Eigen::Matrix3d& dv_dbg() const { return dv_dbg_; }
  const Eigen::Matrix3d& dv_dba() const { return dv_dba_; }
  const Eigen::Matrix3d& dp_dbg() const { return dp_dbg_; }
  const Eigen::Matrix3d& dp_dba() const { return dp_dba_; }

 private:
  ImuNoise noise_;
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_ = Eigen::Vector3d::Zero();
  double duration_ = 0.0;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_ = Eigen::Vector3d::Zero(), p_ = Eigen::Vector3d::Zero();
  Matrix9d covariance_ = Matrix9d::Zero();
  Eigen::Matrix3d dq_dbg_ = Eigen::Matrix3d::Zero(), dv_dbg_ = Eigen::Matrix3d::Zero(),
                  dv_dba_ = Eigen::Matrix3d::Zero(), dp_dbg_ = Eigen::Matrix3d::Zero(),
                  dp_dba_ = Eigen::Matrix3d::Zero();
};

}  // namespace gprodom
