#include "gpr/peaks/peaks_varpro.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gpr/kernels/small_cholesky.h"

namespace gprodom::gpr {
namespace {

// The search ends where step' (J' J) step, in units of the noise variance, is below this.
constexpr double kStepTolerance = 1e-3;
constexpr double kEnergyTolerance = 1e-13;  // of the data's energy: the end for data without noise
constexpr double kFirstDamping = 1e-3;
constexpr double kMinDamping = 1e-4;
constexpr double kMaxDamping = 1e5;
constexpr int kMaxBoundHits = 2;

// Two neighbours of a column, one register: gcc and clang vectorise this at any level of
// optimisation.
using TwoDoubles [[gnu::vector_size(16), gnu::may_alias]] = double;

// One fit of K pulses. With C_k, S_k the cosine and sine of pulse k, the columns stand in pairs:
//     pair k: C_k, S_k    pair K + k: i C_k, i S_k    pair 2 K: ones, data.
// All that a step needs are the 2 x 2 products of pairs ("moments"): the basis' Gram matrix, and,
// since df/dalpha_k = -i (a C + b S) and df/domega_k = i (b C - a S), that of the derivatives too.
// Columns begin, at an even row, with the first sample of their pulse; rows are padded to an even
// number with zeros.
template <int K>
class VarPro {
 public:
  static constexpr int kPairs = 2 * K + 1;
  static constexpr int kLinear = 2 * K + 1;
  static constexpr int kNonlinear = 2 * K;
  static constexpr int kAll = kLinear + kNonlinear;
  using Linear = Eigen::Matrix<double, kLinear, 1>;
  using Nonlinear = Eigen::Matrix<double, kNonlinear, 1>;
  using Pair = Eigen::Matrix2d;

  VarPro(const GroupSamples& samples, DampedSinusoid* pulses);

  FitStatus search(int max_iterations, GroupFit& fit);
  bool finish(GroupFit& fit) const;

 private:
  bool inside(const Nonlinear& theta, int* offender) const;
  double share_inside(const Nonlinear& theta, const Nonlinear& step) const;
  bool evaluate(const Nonlinear& theta);
  void fill(int k, double alpha, double omega);
  Pair moment(int p, int q) const;
  bool solve_linear();
  void linearise();
  Pair derivative_weights(int k) const;
  void keep(const Nonlinear& theta);

  const GroupSamples& samples_;
  DampedSinusoid* pulses_;
  int rows_;
  int first_[kPairs];
  alignas(16) double column_[kPairs][2][kMaxGroupSamples];
  Pair moment_[kPairs][kPairs];  // p <= q

  // At the last trial:
  SmallCholesky<kLinear> basis_;
  Linear projected_;    // L^-1 Phi' y
  Linear coefficient_;  // a_1, b_1, ..., gamma
  double residual_sum_ = 0.0;
  // At the last accepted point:
  Eigen::Matrix<double, kLinear, kNonlinear> mixed_;  // L^-1 Phi' D
  Eigen::Matrix<double, kNonlinear, kNonlinear> normal_;
  Nonlinear gradient_;
};

template <int K>
VarPro<K>::VarPro(const GroupSamples& samples, DampedSinusoid* pulses)
    : samples_(samples), pulses_(pulses), rows_((samples.size + 1) & ~1) {
  const int n = samples.size;
  for (int k = 0; k < K; ++k) {
    const int* begin = samples.index.data();
    const auto row = static_cast<int>(std::lower_bound(begin, begin + n, pulses[k].start) - begin);
    for (const int pair : {k, K + k}) {
      first_[pair] = row & ~1;
      for (auto& column : column_[pair]) column[row & ~1] = column[n] = 0.0;
    }
  }
  first_[2 * K] = 0;
  std::fill_n(column_[2 * K][0], n, 1.0);
  std::copy_n(samples.value.data(), n, column_[2 * K][1]);
  for (auto& column : column_[2 * K]) column[n] = 0.0;
  moment_[2 * K][2 * K] = moment(2 * K, 2 * K);
}

// The four products of two pairs of columns.
template <int K>
typename VarPro<K>::Pair VarPro<K>::moment(int p, int q) const {
  const int from = std::max(first_[p], first_[q]);
  const auto pair = [from](const double* column) {
    return reinterpret_cast<const TwoDoubles*>(column + from);
  };
  const TwoDoubles *p0 = pair(column_[p][0]), *p1 = pair(column_[p][1]);
  const TwoDoubles *q0 = pair(column_[q][0]), *q1 = pair(column_[q][1]);
  TwoDoubles sum00 = {}, sum01 = {}, sum10 = {}, sum11 = {};
  for (int i = 0; i < (rows_ - from) / 2; ++i) {
    sum00 += p0[i] * q0[i];
    sum01 += p0[i] * q1[i];
    sum10 += p1[i] * q0[i];
    sum11 += p1[i] * q1[i];
  }
  Pair result;
  result << sum00[0] + sum00[1], sum01[0] + sum01[1], sum10[0] + sum10[1], sum11[0] + sum11[1];
  return result;
}

template <int K>
bool VarPro<K>::inside(const Nonlinear& theta, int* offender) const {
  for (int k = 0; k < K; ++k) {
    const double alpha = theta[2 * k], omega = theta[2 * k + 1];
    const DampedSinusoid& p = pulses_[k];
    if (!(alpha >= p.alpha_min && alpha <= p.alpha_max && omega >= p.omega_min &&
          omega <= p.omega_max)) {
      *offender = k;
      return false;
    }
  }
  return true;
}

// How much of a step keeps within the bounds.
template <int K>
double VarPro<K>::share_inside(const Nonlinear& theta, const Nonlinear& step) const {
  double share = 1.0;
  const auto limit = [&share](double value, double change, double low, double high) {
    const double room = change < 0.0 ? low - value : high - value;
    if (std::abs(change) * share > std::abs(room)) share = room / change;
  };
  for (int k = 0; k < K; ++k) {
    const DampedSinusoid& p = pulses_[k];
    limit(theta[2 * k], step[2 * k], p.alpha_min, p.alpha_max);
    limit(theta[2 * k + 1], step[2 * k + 1], p.omega_min, p.omega_max);
  }
  return share;
}

// Columns of pulse k by the recurrence z[i + 1] = z[i] exp(-alpha + j omega).
template <int K>
void VarPro<K>::fill(int k, double alpha, double omega) {
  const double decay = std::exp(-alpha);
  const double step_re = decay * std::cos(omega), step_im = decay * std::sin(omega);
  double re = 1.0, im = 0.0;
  const int start = pulses_[k].start;
  int i = 0;
  int row = first_[k];
  if (samples_.index[row] < start) ++row;
  for (; row < samples_.size; ++row) {
    for (const int next = samples_.index[row] - start; i < next; ++i) {
      const double turned = re * step_re - im * step_im;
      im = re * step_im + im * step_re;
      re = turned;
    }
    column_[k][0][row] = re;
    column_[k][1][row] = im;
    column_[K + k][0][row] = i * re;
    column_[K + k][1][row] = i * im;
  }
}

// Moments, linear coefficients and residual at theta; false if the basis is degenerate.
template <int K>
bool VarPro<K>::evaluate(const Nonlinear& theta) {
  for (int k = 0; k < K; ++k) fill(k, theta[2 * k], theta[2 * k + 1]);
  for (int q = 0; q < kPairs; ++q) {
    for (int p = 0; p <= q && p < 2 * K; ++p) moment_[p][q] = moment(p, q);
  }
  return solve_linear();
}

template <int K>
bool VarPro<K>::solve_linear() {
  Eigen::Matrix<double, kLinear, kLinear> gram = Eigen::Matrix<double, kLinear, kLinear>::Zero();
  for (int q = 0; q < K; ++q) {
    for (int p = 0; p <= q; ++p) {
      gram.template block<2, 2>(2 * q, 2 * p) = moment_[p][q].transpose();
    }
    gram.template block<1, 2>(2 * K, 2 * q) = moment_[q][2 * K].col(0).transpose();
    projected_.template segment<2>(2 * q) = moment_[q][2 * K].col(1);
  }
  gram(2 * K, 2 * K) = moment_[2 * K][2 * K](0, 0);
  projected_[2 * K] = moment_[2 * K][2 * K](0, 1);
  if (!basis_.factor(gram)) return false;
  basis_.forward(projected_);
  coefficient_ = projected_;
  basis_.backward(coefficient_);
  residual_sum_ = moment_[2 * K][2 * K](1, 1) - projected_.squaredNorm();
  return std::isfinite(residual_sum_);
}

// (df/dalpha, df/domega) of pulse k = (i C, i S) times this.
template <int K>
typename VarPro<K>::Pair VarPro<K>::derivative_weights(int k) const {
  const double a = coefficient_[2 * k], b = coefficient_[2 * k + 1];
  Pair weights;
  weights << -a, b, -b, -a;
  return weights;
}

// Kaufman's Jacobian of the projected residual is -P D with D the derivatives of f and P the
// projection off the basis. Its normal matrix D'P D is D'D - (L^-1 Phi'D)'(L^-1 Phi'D), the Schur
// complement of the full Gauss-Newton matrix; the step's right-hand side is D'P y.
template <int K>
void VarPro<K>::linearise() {
  Eigen::Matrix<double, kNonlinear, kNonlinear> gram;
  for (int q = 0; q < K; ++q) {
    const Pair weights = derivative_weights(q);
    for (int p = 0; p < K; ++p) {
      mixed_.template block<2, 2>(2 * p, 2 * q) = moment_[p][K + q].lazyProduct(weights);
      if (p > q) continue;
      const Pair half = moment_[K + p][K + q].lazyProduct(weights);
      const Pair block = derivative_weights(p).transpose().lazyProduct(half);
      gram.template block<2, 2>(2 * p, 2 * q) = block;
      gram.template block<2, 2>(2 * q, 2 * p) = block.transpose();
    }
    const Pair constants = moment_[K + q][2 * K].transpose().lazyProduct(weights);
    mixed_.template block<1, 2>(2 * K, 2 * q) = constants.row(0);
    gradient_.template segment<2>(2 * q) = constants.row(1).transpose();
  }
  for (int q = 0; q < kNonlinear; ++q) basis_.forward(mixed_.col(q));
  normal_ = gram - mixed_.transpose().lazyProduct(mixed_);
  gradient_ -= mixed_.transpose().lazyProduct(projected_);
}

template <int K>
FitStatus VarPro<K>::search(int max_iterations, GroupFit& fit) {
  Nonlinear theta;
  for (int k = 0; k < K; ++k)
    theta.template segment<2>(2 * k) << pulses_[k].alpha, pulses_[k].omega;
  fit.freedom = samples_.size - kAll;
  fit.iterations = 0;
  if (fit.freedom < 1) return FitStatus::kTooFewSamples;
  if (!inside(theta, &fit.offender)) return FitStatus::kOutOfBounds;
  if (!evaluate(theta)) return FitStatus::kNotConverged;
  linearise();

  const double floor = kEnergyTolerance * moment_[2 * K][2 * K](1, 1);
  double damping = kFirstDamping;
  double best = residual_sum_;
  int hits = 0;        // steps that a bound cut short
  bool stale = false;  // the last trial was not accepted
  while (damping < kMaxDamping) {
    SmallCholesky<kNonlinear> factor;
    Eigen::Matrix<double, kNonlinear, kNonlinear> damped = normal_;
    damped.diagonal() *= 1.0 + damping;
    if (!factor.factor(damped)) return FitStatus::kNotConverged;
    Nonlinear step = gradient_;
    factor.forward(step);
    const double decrease = step.squaredNorm();
    factor.backward(step);
    if (damping < 1.0 && decrease < kStepTolerance * best / fit.freedom + floor) {
      if (stale) {
        if (!evaluate(theta)) return FitStatus::kNotConverged;
        linearise();
      }
      keep(theta);
      return FitStatus::kConverged;
    }
    if (fit.iterations++ == max_iterations) return FitStatus::kNotConverged;
    Nonlinear trial = theta + step;
    if (!inside(trial, &fit.offender)) {
      if (++hits > kMaxBoundHits) return FitStatus::kOutOfBounds;
      trial = theta + 0.9 * share_inside(theta, step) * step;
    }
    stale = !(evaluate(trial) && residual_sum_ < best);
    damping *= stale ? 10.0 : 0.1;
    if (stale) continue;
    damping = std::max(damping, kMinDamping);
    theta = trial;
    best = residual_sum_;
    linearise();
  }
  return FitStatus::kNotConverged;
}

template <int K>
void VarPro<K>::keep(const Nonlinear& theta) {
  for (int k = 0; k < K; ++k) {
    pulses_[k].alpha = theta[2 * k];
    pulses_[k].omega = theta[2 * k + 1];
    pulses_[k].cosine = coefficient_[2 * k];
    pulses_[k].sine = coefficient_[2 * k + 1];
  }
}

// (J'J)^-1 of all parameters, J = (Phi, D): with L the basis' factor, M = L^-1 Phi'D and N N' = D'P
// D, the inverse of J'J's own factor is [L^-1, 0; -N^-1 M' L^-1, N^-1].
template <int K>
bool VarPro<K>::finish(GroupFit& fit) const {
  SmallCholesky<kNonlinear> factor;
  if (!factor.factor(normal_)) return false;
  const Eigen::Matrix<double, kLinear, kLinear> l = basis_.inverse_lower();
  const Eigen::Matrix<double, kNonlinear, kNonlinear> n = factor.inverse_lower();
  Eigen::Matrix<double, kAll, kAll> root = Eigen::Matrix<double, kAll, kAll>::Zero();
  root.template topLeftCorner<kLinear, kLinear>() = l;
  const Eigen::Matrix<double, kNonlinear, kLinear> slope = mixed_.transpose().lazyProduct(l);
  root.template bottomLeftCorner<kNonlinear, kLinear>() = -n.lazyProduct(slope);
  root.template bottomRightCorner<kNonlinear, kNonlinear>() = n;
  fit.inverse = root.transpose().lazyProduct(root);

  fit.gamma = coefficient_[2 * K];
  for (int k = 0; k < K; ++k) {
    const auto columns = l.template middleCols<2>(2 * k);
    const Pair covariance = columns.transpose().lazyProduct(columns);
    const Eigen::Vector2d ab = coefficient_.template segment<2>(2 * k);
    fit.contribution[k] = ab.dot(covariance.inverse() * ab);
  }
  fit.residual_sum = 0.0;
  for (int row = 0; row < samples_.size; ++row) {
    double residual = samples_.value[row] - fit.gamma;
    for (int k = 0; k < K; ++k) {
      if (samples_.index[row] < pulses_[k].start) continue;
      residual -=
          coefficient_[2 * k] * column_[k][0][row] + coefficient_[2 * k + 1] * column_[k][1][row];
    }
    fit.residual[row] = residual;
    fit.residual_sum += residual * residual;
  }
  return true;
}

template <int K>
void fit_joint(const GroupSamples& samples, DampedSinusoid* pulses, int max_iterations,
               GroupFit& fit) {
  VarPro<K> problem(samples, pulses);
  fit.status = problem.search(max_iterations, fit);
  if (fit.status == FitStatus::kConverged && !problem.finish(fit)) {
    fit.status = FitStatus::kNotConverged;
  }
}

}  // namespace

void fit_pulses(const GroupSamples& samples, DampedSinusoid* pulses, int count, int max_iterations,
                GroupFit& fit) {
  fit.offender = count - 1;
  fit.status = FitStatus::kTooFewSamples;
  if (samples.size < 4 * count + 2 || samples.index[samples.size - 1] < pulses[count - 1].start) {
    return;
  }
  switch (count) {
    case 1:
      return fit_joint<1>(samples, pulses, max_iterations, fit);
    case 2:
      return fit_joint<2>(samples, pulses, max_iterations, fit);
    default:
      return fit_joint<3>(samples, pulses, max_iterations, fit);
  }
}

}  // namespace gprodom::gpr
