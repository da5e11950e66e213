#include "estimation/increments/imu_preintegration.h"

#include <cmath>

#include "estimation/kernels/so3.h"

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

// F P F^T for F = [E 0 0; A 1 0; B dt 1], by blocks of three.
Matrix9d carried(const Matrix9d& P, const Matrix3d& E, const Matrix3d& A, const Matrix3d& B,
                 double dt) {
  auto block = [](auto& M, int i, int j) { return M.template block<3, 3>(3 * i, 3 * j); };
  Matrix9d T;  // F P
  for (int j = 0; j < 3; ++j) {
    const Matrix3d P0 = block(P, 0, j), P1 = block(P, 1, j);
    block(T, 0, j) = E * P0;
    block(T, 1, j) = A * P0 + P1;
    block(T, 2, j) = B * P0 + dt * P1 + block(P, 2, j);
  }
  Matrix9d R;  // T F^T, which is symmetric
  for (int i = 0; i < 3; ++i) {
    const Matrix3d T0 = block(T, i, 0), T1 = block(T, i, 1);
    block(R, i, 0) = T0 * E.transpose();
    if (i > 0) block(R, i, 1) = T0 * A.transpose() + T1;
    if (i > 1) block(R, i, 2) = T0 * B.transpose() + dt * T1 + block(T, i, 2);
  }
  block(R, 0, 1) = block(R, 1, 0).transpose();
  block(R, 0, 2) = block(R, 2, 0).transpose();
  block(R, 1, 2) = block(R, 2, 1).transpose();
  return R;
}

// P += G G^T for G = [q 0; v w; p s], by blocks of three.
void add_noise(const Matrix3d& q, const Matrix3d& v, const Matrix3d& p, const Matrix3d& w,
               const Matrix3d& s, Matrix9d& P) {
  const auto add = [&P](int i, int j, const Matrix3d& product) {
    P.block<3, 3>(3 * i, 3 * j) += product;
    if (i != j) P.block<3, 3>(3 * j, 3 * i) += product.transpose();
  };
  add(0, 0, q * q.transpose());
  add(1, 0, v * q.transpose());
  add(2, 0, p * q.transpose());
  add(1, 1, v * v.transpose() + w * w.transpose());
  add(2, 1, p * v.transpose() + s * w.transpose());
  add(2, 2, p * p.transpose() + s * s.transpose());
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

  // error = F error + G [rate noise; force noise], noise held over the step. By blocks of three:
  // F = [step_t 0 0; v_theta 1 0; p_theta dt 1], G = [Jr_dt 0; v_rate R_once; p_rate R_twice].
  covariance_ = carried(covariance_, step_t, v_theta, p_theta, dt);
  const double gyro_sigma = noise.gyro_density / std::sqrt(dt);
  const double sideways = std::max(noise.accel_density, noise.sideways_density);
  const auto accel_sigma =
      (Vector3d(noise.accel_density, sideways, noise.accel_density) / std::sqrt(dt)).eval();
  add_noise(gyro_sigma * Jr_dt, gyro_sigma * v_rate, gyro_sigma * p_rate,
            R_once * accel_sigma.asDiagonal(), R_twice * accel_sigma.asDiagonal(), covariance_);

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
