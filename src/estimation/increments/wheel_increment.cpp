#include "estimation/increments/wheel_increment.h"

#include <cmath>

#include "estimation/kernels/so3.h"

namespace gprodom {

void WheelIncrement::integrate(const Eigen::Vector3d& angular_velocity, double dt,
                               double distance_m) {
  const Eigen::Vector3d phi = (angular_velocity - gyro_bias_) * dt;
  const Eigen::Vector3d half = 0.5 * phi;
  const Eigen::Quaterniond middle = q_ * so3::exp(half);
  const Eigen::Matrix3d middle_dbg =
      so3::exp_matrix(-half) * dq_dbg_ - 0.5 * dt * so3::right_jacobian(half);
  const Eigen::Matrix3d R = middle.toRotationMatrix();
  displacement_ += R.col(0) * distance_m;
  d_dbg_ -= R * so3::skew(Eigen::Vector3d(distance_m, 0, 0)) * middle_dbg;
  q_ = (q_ * so3::exp(phi)).normalized();
  dq_dbg_ = so3::exp_matrix(-phi) * dq_dbg_ - dt * so3::right_jacobian(phi);
  distance_ += distance_m;
  path_ += std::abs(distance_m);
}

WheelIncrement WheelIncrement::stretched(double factor) const {
  WheelIncrement result = *this;
  result.displacement_ *= factor;
  result.d_dbg_ *= factor;
  result.distance_ *= factor;
  result.path_ *= factor;
  return result;
}

Eigen::Vector3d WheelIncrement::variance(const WheelNoise& noise) const {
  const Eigen::Array3d per_metre(noise.forward, noise.lateral, noise.vertical);
  return (per_metre.square() * path_ + noise.floor * noise.floor).matrix();
}

}  // namespace gprodom
