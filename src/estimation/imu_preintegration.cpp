#include "gprodom/imu_preintegration.h"

#include "gprodom/so3.h"

namespace gprodom {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// d/d phi of f phi x a + g phi x (phi x a), where d f = f' phi . d phi and d g = g' phi . d phi.
Matrix3d turned_derivative(const Vector3d& a, const Vector3d& phi, double f, double df, double g,
                           double dg) {
  const Vector3d b = phi.cross(a), c = phi.cross(b);
  Matrix3d d = -f * so3::skew(a) + (df * b + dg * c) * phi.transpose();
  d += g * (phi * a.transpose() - 2 * a * phi.transpose());
  d.diagonal().array() += g * phi.dot(a);
  return d;
}

}  // namespace

ImuPreintegration::ImuPreintegration(const ImuNoise& noise, const Vector3d& gyro_bias,
                                     const Vector3d& accel_bias)
    : noise_(noise), gyro_bias_(gyro_bias), accel_bias_(accel_bias) {}

void ImuPreintegration::integrate(const Vector3d& acceleration, const Vector3d& angular_velocity,
                                  double dt, const ImuNoise& noise) {
  const Vector3d a = acceleration - accel_bias_;
  const Vector3d phi = (angular_velocity - gyro_bias_) * dt;
  const Matrix3d k = so3::skew(phi), kk = k * k, R = q_.toRotationMatrix();
  const so3::Series c(phi.norm());
  // Integrals of Exp(omega t) over the step: once (velocity, over dt), twice (position, over dt^2).
  const Matrix3d once = Matrix3d::Identity() + c.s2 * k + c.s3 * kk;
  const Matrix3d twice = 0.5 * Matrix3d::Identity() + c.s3 * k + c.s4 * kk;
  const Matrix3d step_t = Matrix3d::Identity() - c.s1 * k + c.s2 * kk;  // Exp(-phi)
  const Matrix3d Jr_dt = once.transpose() * dt;  // right Jacobian of phi is once(-phi)
  const Matrix3d R_once = R * once * dt, R_twice = R * twice * (dt * dt);

  // How a rate error within the step turns the force in velocity and position.
  const Matrix3d v_rate = R * turned_derivative(a, phi, c.s2, c.d2, c.s3, c.d3) * (dt * dt);
  const Matrix3d p_rate = R * turned_derivative(a, phi, c.s3, c.d3, c.s4, c.d4) * (dt * dt * dt);
  const Matrix3d v_theta = -R * so3::skew(once * a) * dt;
  const Matrix3d p_theta = -R * so3::skew(twice * a) * (dt * dt);

  // Covariance: error = F error + G [rate noise; force noise], noise held over the step.
  Matrix9d F = Matrix9d::Identity();
  F.block<3, 3>(0, 0) = step_t;
  F.block<3, 3>(3, 0) = v_theta;
  F.block<3, 3>(6, 0) = p_theta;
  F.block<3, 3>(6, 3).diagonal().setConstant(dt);
  Eigen::Matrix<double, 9, 6> G;
  G << Jr_dt, Matrix3d::Zero(), v_rate, R_once, p_rate, R_twice;
  Eigen::Matrix<double, 6, 1> variance;
  variance << Vector3d::Constant(noise.gyro_density * noise.gyro_density / dt),
      Vector3d::Constant(noise.accel_density * noise.accel_density / dt);
  const Matrix9d FP = F * covariance_;
  const Eigen::Matrix<double, 9, 6> GQ = G * variance.asDiagonal();
  covariance_.noalias() = FP * F.transpose() + GQ * G.transpose();

  // A bias acts like noise of the opposite sign that stays.
  dp_dbg_ += dv_dbg_ * dt + p_theta * dq_dbg_ - p_rate;
  dp_dba_ += dv_dba_ * dt - R_twice;
  dv_dbg_ += v_theta * dq_dbg_ - v_rate;
  dv_dba_ -= R_once;
  dq_dbg_ = step_t * dq_dbg_ - Jr_dt;

  p_ += v_ * dt + R_twice * a;
  v_ += R_once * a;
  q_ = (q_ * so3::exp(phi)).normalized();
  duration_ += dt;
}

ImuPreintegration::Delta ImuPreintegration::delta(const Vector3d& gyro_bias,
                                                  const Vector3d& accel_bias) const {
  const Vector3d dbg = gyro_bias - gyro_bias_, dba = accel_bias - accel_bias_;
  return {q_ * so3::exp(dq_dbg_ * dbg), v_ + dv_dbg_ * dbg + dv_dba_ * dba,
          p_ + dp_dbg_ * dbg + dp_dba_ * dba};
}

}  // namespace gprodom
