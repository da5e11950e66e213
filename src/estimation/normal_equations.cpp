#include "estimation/normal_equations.h"

#include <algorithm>

#include "estimation/kernels/block_products.h"

namespace gprodom {

namespace {

static_assert(kBlockSize == kStateDim);

// Typical sizes of the error's rows. In these units all pivots lie within a few orders of
// magnitude.
const StateVector kUnits = (StateVector() << Eigen::Vector3d::Constant(1e-3),
                            Eigen::Vector3d::Constant(1e-2), Eigen::Vector3d::Constant(1e-2),
                            Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(1e-2), 1e-2)
                               .finished();

}  // namespace

// Finds the envelope and empties the blocks in it.
void NormalEquations::shape(const Window& window) {
  const size_t n = window.states.size(), held = window.prior.states();
  bandwidth_ = std::max<size_t>(1, held > 0 ? held - 1 : 0);
  first_.assign(n, 0);
  for (size_t i = held; i < n; ++i) first_[i] = i;
  for (const Window::Link& link : window.links) {
    bandwidth_ = std::max(bandwidth_, static_cast<size_t>(link.b - link.a));
    size_t& first = first_[window.index(link.b)];
    first = std::min(first, window.index(link.a));
  }
  H_.resize(n * (bandwidth_ + 1));
  L_.resize(H_.size());
  for (size_t i = 0; i < n; ++i)
    for (size_t j = first_[i]; j <= i; ++j) block(H_, i, j).setZero();
  g_.assign(n, StateVector::Zero());
}

double NormalEquations::add_prior(const Window& window) {
  const int n = window.prior.states();
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
  window.prior.evaluate(window.states.data(), r, &J);
  for (int i = 0; i < n; ++i) J.middleCols<kStateDim>(i * kStateDim) *= kUnits.asDiagonal();
  for (int i = 0; i < n; ++i) {
    const auto Ji = J.middleCols<kStateDim>(i * kStateDim);
    g_[i].noalias() += Ji.transpose() * r;
    for (int j = 0; j <= i; ++j)
      block(H_, i, j).noalias() += Ji.transpose() * J.middleCols<kStateDim>(j * kStateDim);
  }
  return 0.5 * r.squaredNorm();
}

double NormalEquations::linearise(const Window& window) {
  shape(window);
  double sum = add_prior(window);
  Residual r;
  Jacobian Ja, Jb;
  for (const Window::Link& link : window.links) {
    const size_t a = window.index(link.a), b = window.index(link.b);
    link.factor->evaluate(window.states[a], window.states[b], r, &Ja, &Jb);
    sum += robust_cost(*link.factor, r);
    weight_rows(*link.factor, r, Ja, Jb);
    const auto rows = static_cast<int>(r.size());
    const BlockRows A{Ja.data(), scale_columns(Ja.data(), rows, kUnits)};
    const BlockRows B{Jb.data(), scale_columns(Jb.data(), rows, kUnits)};
    add_product(A, A, rows, Part::kLower, block(H_, a, a));
    add_product(B, A, rows, Part::kAll, block(H_, b, a));
    add_product(B, B, rows, Part::kLower, block(H_, b, b));
    add_rows(Ja.data(), r.data(), rows, g_[a]);
    add_rows(Jb.data(), r.data(), rows, g_[b]);
  }
  return sum;
}

// Left-looking block Cholesky of the envelope, oldest state first. Fill-in occurs in a row only
// from its first block on.
bool NormalEquations::eliminate(double damping) {
  const size_t n = g_.size();
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = first_[i]; j <= i; ++j) {
      StateMatrix& Lij = block(L_, i, j);
      Lij = block(H_, i, j);
      if (i == j) Lij.diagonal() *= 1 + damping;
      const size_t shared = std::max(first_[i], first_[j]);
      const Part part = i == j ? Part::kLower : Part::kAll;
      for (size_t k = shared; k < j; ++k)
        subtract_product(block(L_, i, k), block(L_, j, k), part, Lij);
      if (j < i)
        solve_transposed_on_the_right(block(L_, j, j), Lij);
      else if (!cholesky(Lij))
        return false;
    }
  }
  return true;
}

// L L^T x = x, in the units of the equations. Returns |L^-1 x|^2.
double NormalEquations::substitute(std::vector<StateVector>& x) const {
  const size_t n = g_.size();
  double square = 0;
  for (size_t i = 0; i < n; ++i) {
    StateVector y = x[i];
    for (size_t k = first_[i]; k < i; ++k) y.noalias() -= block(L_, i, k).lazyProduct(x[k]);
    x[i] = block(L_, i, i).triangularView<Eigen::Lower>().solve(y);
    square += x[i].squaredNorm();
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < std::min(n, i + bandwidth_ + 1); ++k)
      if (first_[k] <= i) x[i].noalias() -= block(L_, k, i).transpose().lazyProduct(x[k]);
    block(L_, i, i).transpose().triangularView<Eigen::Upper>().solveInPlace(x[i]);
  }
  return square;
}

double NormalEquations::solve_step(std::vector<StateVector>& step) const {
  step.resize(g_.size());
  std::transform(g_.begin(), g_.end(), step.begin(), [](const StateVector& g) { return -g; });
  const double decrease = 0.5 * substitute(step);
  for (auto& s : step) s.array() *= kUnits.array();
  return decrease;
}

std::vector<StateVector> NormalEquations::covariance_with(const std::vector<StateVector>& d) const {
  std::vector<StateVector> x = d;
  for (auto& s : x) s.array() *= kUnits.array();
  substitute(x);
  for (auto& s : x) s.array() *= kUnits.array();
  return x;
}

StateMatrix NormalEquations::newest_covariance() const {
  const StateMatrix L_inverse = block(L_, g_.size() - 1, g_.size() - 1)
                                    .triangularView<Eigen::Lower>()
                                    .solve(StateMatrix::Identity());
  const StateMatrix inverse =
      kUnits.asDiagonal() * (L_inverse.transpose() * L_inverse) * kUnits.asDiagonal();
  return 0.5 * (inverse + inverse.transpose());
}

Eigen::Vector4d NormalEquations::newest_information() const {
  const StateMatrix& L = block(L_, g_.size() - 1, g_.size() - 1);
  Eigen::Vector4d information;
  for (int i = 0; i < 4; ++i) {
    const int k = row::kUnmeasured[i];
    information[i] = L.row(k).head(k + 1).squaredNorm() / (kUnits[k] * kUnits[k]);
  }
  return information;
}

}  // namespace gprodom
