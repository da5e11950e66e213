// Cholesky factors of matrices of a few rows, on the stack. Eigen's own solvers go through code for
// matrices of any size here and take several times as long.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gprodom::gpr {

// A = L L' of a symmetric N x N matrix, of which the lower triangle is read.
template <int N>
class SmallCholesky {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  // False if A is not positive definite to working precision.
  bool factor(const Matrix& a) {
    lower_ = a;
    for (int j = 0; j < N; ++j) {
      const double pivot = lower_(j, j);
      if (!(pivot > kSmallest * a(j, j)) || !std::isfinite(pivot)) return false;
      const double root = std::sqrt(pivot);
      reciprocal_[j] = 1.0 / root;
      lower_(j, j) = root;
      for (int i = j + 1; i < N; ++i) lower_(i, j) *= reciprocal_[j];
      for (int c = j + 1; c < N; ++c) {
        const double factor = lower_(c, j);
        for (int i = c; i < N; ++i) lower_(i, c) -= lower_(i, j) * factor;
      }
    }
    return true;
  }

  // x -> L^-1 x, in place.
  template <typename Column>
  void forward(Column&& x) const {
    for (int j = 0; j < N; ++j) {
      x[j] *= reciprocal_[j];
      for (int i = j + 1; i < N; ++i) x[i] -= lower_(i, j) * x[j];
    }
  }

  // x -> L'^-1 x, in place.
  template <typename Column>
  void backward(Column&& x) const {
    for (int j = N - 1; j >= 0; --j) {
      for (int i = j + 1; i < N; ++i) x[j] -= lower_(i, j) * x[i];
      x[j] *= reciprocal_[j];
    }
  }

  // L^-1, lower triangular: A^-1 = L^-T L^-1.
  Matrix inverse_lower() const {
    Matrix inverse = Matrix::Zero();
    for (int c = 0; c < N; ++c) {
      inverse(c, c) = reciprocal_[c];
      for (int i = c + 1; i < N; ++i) {
        double sum = 0.0;
        for (int j = c; j < i; ++j) sum -= lower_(i, j) * inverse(j, c);
        inverse(i, c) = sum * reciprocal_[i];
      }
    }
    return inverse;
  }

 private:
  static constexpr double kSmallest = 1e-13;  // pivot over the diagonal

  Matrix lower_;
  double reciprocal_[N];
};

}  // namespace gprodom::gpr
