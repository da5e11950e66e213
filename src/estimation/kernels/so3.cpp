#include "estimation/kernels/so3.h"

namespace gprodom::so3 {

Matrix3d exp_matrix(const Vector3d& phi) {
  const Series a(phi.norm());
  const Matrix3d k = skew(phi);
  return Matrix3d::Identity() + a.s1 * k + a.s2 * (k * k);
}

Quaterniond exp(const Vector3d& phi) {
  const double half = 0.5 * phi.norm();
  const Vector3d xyz = 0.5 * Series(half).s1 * phi;
  return {std::cos(half), xyz.x(), xyz.y(), xyz.z()};
}

Vector3d log(const Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Vector3d v = sign * q.vec();
  const double n = v.norm();
  const double half = std::atan2(n, sign * q.w());
  return n < 1e-10 ? Vector3d(2 * v) : Vector3d(2 * half / n * v);
}

Matrix3d left_jacobian(const Vector3d& phi) {
  const Series a(phi.norm());
  const Matrix3d k = skew(phi);
  return Matrix3d::Identity() + a.s2 * k + a.s3 * (k * k);
}

Matrix3d left_jacobian_inverse(const Vector3d& phi) {
  const double x = phi.squaredNorm(), angle = std::sqrt(x);
  const Matrix3d k = skew(phi);
  const double c = angle < kSmallAngle
                       ? (1.0 + x / 60 * (1 + x / 42)) / 12
                       : (1 - 0.5 * angle * std::sin(angle) / (1 - std::cos(angle))) / x;
  return Matrix3d::Identity() - 0.5 * k + c * (k * k);
}

}  // namespace gprodom::so3
