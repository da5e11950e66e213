// Sparse normal equations of a least squares problem that is linearised many times: every pass adds
// the same entries in the same order, so their places and the order of elimination are found once.
#pragma once

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace gprodom {

constexpr int kNoUnknown = -1;

class NormalMatrix {
 public:
  explicit NormalMatrix(std::size_t unknowns)
      : matrix_(static_cast<int>(unknowns), static_cast<int>(unknowns)),
        gradient_(Eigen::VectorXd::Zero(matrix_.rows())) {}

  // Begins a pass.
  void clear() {
    next_ = 0;
    work_ += static_cast<double>(slots_.size());
    gradient_.setZero();
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  }

  // Adds weight J^T J and weight J^T r. Derivatives by kNoUnknown are left out.
  template <int Rows, int Columns>
  void add(const std::array<int, Columns>& unknowns, const Eigen::Matrix<double, Rows, Columns>& J,
           const Eigen::Matrix<double, Rows, 1>& r, double weight) {
    const Eigen::Matrix<double, Columns, Columns> H = weight * (J.transpose() * J);
    const Eigen::Matrix<double, Columns, 1> g = weight * (J.transpose() * r);
    for (int i = 0; i < Columns; ++i) {
      if (unknowns[i] == kNoUnknown) continue;
      gradient_[unknowns[i]] += g[i];
      for (int j = 0; j <= i; ++j) {
        if (unknowns[j] != kNoUnknown) put(unknowns[i], unknowns[j], H(i, j));
      }
    }
  }

  void hold(int unknown, double weight) { put(unknown, unknown, weight); }

  // Ends a pass. Raises the diagonal to (1 + damping) of itself. Returns false unless the equations
  // are positive definite.
  bool factorise(double damping = 0.0);

  // Arithmetic done so far: multiplications of all factorisations, and entries of all passes but
  // the first. The same for the same problem on any machine.
  double work() const { return work_; }

  const Eigen::VectorXd& gradient() const { return gradient_; }
  template <typename Columns>
  auto solve(const Columns& right) const {
    return factorised_.solve(right);
  }

 private:
  void put(int i, int j, double value) {
    if (slots_.empty())
      entries_.emplace_back(std::max(i, j), std::min(i, j), value);
    else
      matrix_.valuePtr()[slots_[next_++]] += value;
  }
  void find_slots();
  void count_work();

  Eigen::SparseMatrix<double> matrix_;  // its lower triangle
  Eigen::VectorXd gradient_;
  std::vector<Eigen::Triplet<double>> entries_;  // of the first pass
  std::vector<int> slots_;                       // of the entries among the matrix's values
  std::size_t next_ = 0;
  double work_ = 0.0, work_of_factorising_ = 0.0;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factorised_;
};

}  // namespace gprodom
