// Rotations: exponential, logarithm and Jacobians of SO(3), exact for every angle up to pi.
// Formulas: docs/estimation.md, section "Rotations"; Forster et al., T-RO 2017, section III.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace gprodom::so3 {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// skew(a) b = a x b
inline Matrix3d skew(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// Below this angle the series of order 6 are exact to rounding.
constexpr double kSmallAngle = 0.02;

// Coefficients of the power series sum_k (-1)^k phi^(2k) / (2k + n)!, n = 1..4: with phi the angle,
// s1 = sin/phi, s2 = (1 - cos)/phi^2, s3 = (phi - sin)/phi^3, s4 = (phi^2/2 + cos - 1)/phi^4.
struct Series {
  double s1, s2, s3, s4;
  double d2, d3, d4;  // d s_n / d phi = d_n phi, since s_n' = (s_{n-1} - n s_n) / angle

  explicit Series(double angle) {
    const double x = angle * angle;
    if (angle < kSmallAngle) {
      s1 = 1 - x / 6 * (1 - x / 20 * (1 - x / 42));
      s2 = 0.5 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56)));
      s3 = 1.0 / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72)));
      s4 = 1.0 / 24 * (1 - x / 30 * (1 - x / 56 * (1 - x / 90)));
      d2 = -1.0 / 12 * (1 - x / 15 * (1 - x * 3 / 112));
      d3 = -1.0 / 60 * (1 - x / 21 * (1 - x / 48));
      d4 = -1.0 / 360 * (1 - x / 28 * (1 - x / 60));
    } else {
      const double s = std::sin(angle), c = std::cos(angle);
      s1 = s / angle;
      s2 = (1 - c) / x;
      s3 = (angle - s) / (x * angle);
      s4 = (0.5 * x + c - 1) / (x * x);
      d2 = (s1 - 2 * s2) / x;
      d3 = (s2 - 3 * s3) / x;
      d4 = (s3 - 4 * s4) / x;
    }
  }
};

Matrix3d exp_matrix(const Vector3d& phi);
Quaterniond exp(const Vector3d& phi);

// Rotation vector of norm at most pi.
Vector3d log(const Quaterniond& q);

// exp(phi + d) = exp(left_jacobian(phi) d) exp(phi) to first order.
Matrix3d left_jacobian(const Vector3d& phi);
inline Matrix3d right_jacobian(const Vector3d& phi) { return left_jacobian(-phi); }

// Valid below 2 pi.
Matrix3d left_jacobian_inverse(const Vector3d& phi);
inline Matrix3d right_jacobian_inverse(const Vector3d& phi) { return left_jacobian_inverse(-phi); }

}  // namespace gprodom::so3
