#include "gprodom/gpr/peaks_varpro.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace gprodom::gpr {
namespace {

// The search ends where delta' (J' J) delta, in units of the noise variance, is below this.
constexpr double kStepTolerance = 1e-3;
constexpr double kEnergyTolerance = 1e-13;  // of the data's energy: the end for data without noise
constexpr int kMaxBoundHits = 2;
constexpr double kFirstDamping = 1e-3;
constexpr double kMinDamping = 1e-4;
constexpr double kMaxDamping = 1e5;

// Everything of one fit of K pulses. Columns of the basis: C_k, S_k (cosine and sine of pulse k),
// then ones; columns of the derivative: df/dalpha_k, df/domega_k. Each column begins, at an even
// row, with the first sample of its pulse; rows are padded with zeros to an even number.
template <int K>
class VarPro {
 public:
  static constexpr int kLinear = 2 * K + 1;
  static constexpr int kNonlinear = 2 * K;
  static constexpr int kAll = kLinear + kNonlinear;
  using Nonlinear = Eigen::Matrix<double, kNonlinear, 1>;
  using Linear = Eigen::Matrix<double, kLinear, 1>;

  VarPro(const GroupSamples& samples, DampedSinusoid* pulses);

  FitStatus search(int max_iterations, GroupFit& fit);
  void finish(GroupFit& fit);

 private:
  using Column = Eigen::Map<const Eigen::VectorXd, Eigen::Aligned16>;

  bool inside(const Nonlinear& theta, int* offender) const;
  double share_inside(const Nonlinear& theta, const Nonlinear& step) const;
  bool solve_linear(const Nonlinear& theta);
  void fill_basis(int k, double alpha, double omega);
  bool linearise();
  double dot(int p, int q) const;

  const GroupSamples& samples_;
  DampedSinusoid* pulses_;
  int rows_;                     // even
  std::array<int, kAll> first_;  // row where a column begins, even
  alignas(16) double column_[kAll][kMaxGroupSamples];
  alignas(16) double value_[kMaxGroupSamples];
  alignas(16) double residual_[kMaxGroupSamples];
  double energy_ = 0.0;

  // At the trial:
  Linear coefficient_ = Linear::Zero();
  double residual_sum_ = 0.0;
  Eigen::Matrix<double, kLinear, kLinear> basis_gram_;
  Eigen::LLT<Eigen::Matrix<double, kLinear, kLinear>> basis_factor_;
  // At the accepted point:
  Eigen::Matrix<double, kLinear, kNonlinear> mixed_gram_;
  Eigen::Matrix<double, kNonlinear, kNonlinear> schur_;
  Nonlinear gradient_;
};

template <int K>
VarPro<K>::VarPro(const GroupSamples& samples, DampedSinusoid* pulses)
    : samples_(samples), pulses_(pulses), rows_((samples.size + 1) & ~1) {
  const int n = samples.size;
  std::copy_n(samples.value.data(), n, value_);
  if (rows_ > n) value_[n] = 0.0;
  for (int i = 0; i < n; ++i) energy_ += value_[i] * value_[i];
  first_[kLinear - 1] = 0;
  std::fill_n(column_[kLinear - 1], rows_, 1.0);
  if (rows_ > n) column_[kLinear - 1][n] = 0.0;
  for (int k = 0; k < K; ++k) {
    const int* begin = samples.index.data();
    const auto row = static_cast<int>(std::lower_bound(begin, begin + n, pulses[k].start) - begin);
    for (const int column : {2 * k, 2 * k + 1, kLinear + 2 * k, kLinear + 2 * k + 1}) {
      first_[static_cast<std::size_t>(column)] = row & ~1;
      column_[column][row & ~1] = 0.0;
      if (rows_ > n) column_[column][n] = 0.0;
    }
  }
}

template <int K>
double VarPro<K>::dot(int p, int q) const {
  const int from =
      std::max(first_[static_cast<std::size_t>(p)], first_[static_cast<std::size_t>(q)]);
  return Column(column_[p] + from, rows_ - from).dot(Column(column_[q] + from, rows_ - from));
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

// C and S by the recurrence z[i + 1] = z[i] exp(-alpha + j omega).
template <int K>
void VarPro<K>::fill_basis(int k, double alpha, double omega) {
  double* cosine = column_[2 * k];
  double* sine = column_[2 * k + 1];
  const double decay = std::exp(-alpha);
  const double step_re = decay * std::cos(omega), step_im = decay * std::sin(omega);
  double re = 1.0, im = 0.0;
  int at = pulses_[k].start;
  int row = first_[static_cast<std::size_t>(2 * k)];
  if (samples_.index[static_cast<std::size_t>(row)] < at) ++row;
  for (; row < samples_.size; ++row) {
    for (; at < samples_.index[static_cast<std::size_t>(row)]; ++at) {
      const double next = re * step_re - im * step_im;
      im = re * step_im + im * step_re;
      re = next;
    }
    cosine[row] = re;
    sine[row] = im;
  }
}

// The linear coefficients and the residual at theta; false if the basis is degenerate.
template <int K>
bool VarPro<K>::solve_linear(const Nonlinear& theta) {
  for (int k = 0; k < K; ++k) fill_basis(k, theta[2 * k], theta[2 * k + 1]);
  Linear projection;
  for (int q = 0; q < kLinear; ++q) {
    for (int p = 0; p <= q; ++p) basis_gram_(q, p) = dot(p, q);
    const int from = first_[static_cast<std::size_t>(q)];
    projection[q] =
        Column(column_[q] + from, rows_ - from).dot(Column(value_ + from, rows_ - from));
  }
  basis_factor_.compute(basis_gram_);
  if (basis_factor_.info() != Eigen::Success) return false;
  coefficient_ = basis_factor_.solve(projection);

  Eigen::Map<Eigen::VectorXd, Eigen::Aligned16> residual(residual_, rows_);
  residual = Column(value_, rows_);
  for (int q = 0; q < kLinear; ++q) {
    const int from = first_[static_cast<std::size_t>(q)];
    residual.tail(rows_ - from) -= coefficient_[q] * Column(column_[q] + from, rows_ - from);
  }
  residual_sum_ = residual.squaredNorm();
  return std::isfinite(residual_sum_);
}

// Kaufman's Jacobian of the projected residual, -P_perp (dPhi/dtheta) c: its normal matrix is the
// Schur complement of the full Gauss-Newton matrix on theta, its gradient -D' r.
template <int K>
bool VarPro<K>::linearise() {
  Eigen::Matrix<double, kNonlinear, kNonlinear> gram;
  for (int k = 0; k < K; ++k) {
    const double a = coefficient_[2 * k], b = coefficient_[2 * k + 1];
    const double* cosine = column_[2 * k];
    const double* sine = column_[2 * k + 1];
    double* by_alpha = column_[kLinear + 2 * k];
    double* by_omega = column_[kLinear + 2 * k + 1];
    int row = first_[static_cast<std::size_t>(2 * k)];
    if (samples_.index[static_cast<std::size_t>(row)] < pulses_[k].start) ++row;
    for (; row < samples_.size; ++row) {
      const double i = samples_.index[static_cast<std::size_t>(row)] - pulses_[k].start;
      by_alpha[row] = -i * (a * cosine[row] + b * sine[row]);
      by_omega[row] = i * (b * cosine[row] - a * sine[row]);
    }
  }
  for (int q = 0; q < kNonlinear; ++q) {
    for (int p = 0; p < kLinear; ++p) mixed_gram_(p, q) = dot(p, kLinear + q);
    for (int p = 0; p <= q; ++p) gram(p, q) = gram(q, p) = dot(kLinear + p, kLinear + q);
    const int from = first_[static_cast<std::size_t>(kLinear + q)];
    gradient_[q] = Column(column_[kLinear + q] + from, rows_ - from)
                       .dot(Column(residual_ + from, rows_ - from));
  }
  const Eigen::Matrix<double, kLinear, kNonlinear> half =
      basis_factor_.matrixL().solve(mixed_gram_);
  schur_.noalias() = gram - half.transpose().lazyProduct(half);
  return schur_.allFinite();
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
  if (!solve_linear(theta) || !linearise()) return FitStatus::kNotConverged;

  FitStatus status = FitStatus::kNotConverged;
  double damping = kFirstDamping;
  double best = residual_sum_;
  int hits = 0;        // steps that a bound cut short
  bool stale = false;  // the trial's columns are not those of theta
  while (fit.iterations < max_iterations && damping < kMaxDamping) {
    Eigen::Matrix<double, kNonlinear, kNonlinear> damped = schur_;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::LLT<Eigen::Matrix<double, kNonlinear, kNonlinear>> factor(damped);
    if (factor.info() != Eigen::Success) return FitStatus::kNotConverged;
    const Nonlinear step = factor.solve(gradient_);
    if (damping < 1.0 &&
        step.dot(gradient_) < kStepTolerance * best / fit.freedom + kEnergyTolerance * energy_) {
      status = FitStatus::kConverged;
      break;
    }
    Nonlinear trial = theta + step;
    if (!inside(trial, &fit.offender)) {
      if (++hits > kMaxBoundHits) return FitStatus::kOutOfBounds;
      trial = theta + 0.9 * share_inside(theta, step) * step;
    }
    ++fit.iterations;
    if (solve_linear(trial) && residual_sum_ < best) {
      theta = trial;
      best = residual_sum_;
      stale = false;
      damping = std::max(0.1 * damping, kMinDamping);
      if (!linearise()) return FitStatus::kNotConverged;
    } else {
      stale = true;
      damping *= 10.0;
    }
  }
  if (status != FitStatus::kConverged) return status;
  if (stale && !(solve_linear(theta) && linearise())) return FitStatus::kNotConverged;
  for (int k = 0; k < K; ++k) {
    pulses_[k].alpha = theta[2 * k];
    pulses_[k].omega = theta[2 * k + 1];
    pulses_[k].cosine = coefficient_[2 * k];
    pulses_[k].sine = coefficient_[2 * k + 1];
  }
  return status;
}

// (J' J)^-1 of all parameters from the blocks: with G the basis' Gram matrix, E the mixed one and S
// the Schur complement, [[G^-1 + G^-1 E S^-1 E' G^-1, -G^-1 E S^-1], [., S^-1]].
template <int K>
void VarPro<K>::finish(GroupFit& fit) {
  fit.gamma = coefficient_[kLinear - 1];
  fit.residual_sum = residual_sum_;
  const Eigen::LLT<Eigen::Matrix<double, kNonlinear, kNonlinear>> factor(schur_);
  if (factor.info() != Eigen::Success) {
    fit.status = FitStatus::kNotConverged;
    return;
  }
  const Eigen::Matrix<double, kNonlinear, kNonlinear> s_inverse =
      factor.solve(Eigen::Matrix<double, kNonlinear, kNonlinear>::Identity());
  const Eigen::Matrix<double, kLinear, kLinear> g_inverse =
      basis_factor_.solve(Eigen::Matrix<double, kLinear, kLinear>::Identity());
  for (int k = 0; k < K; ++k) {
    const Eigen::Matrix2d block = g_inverse.template block<2, 2>(2 * k, 2 * k);
    const Eigen::Vector2d ab = coefficient_.template segment<2>(2 * k);
    fit.contribution[static_cast<std::size_t>(k)] = ab.dot(block.inverse() * ab);
  }
  const Eigen::Matrix<double, kLinear, kNonlinear> slope = g_inverse.lazyProduct(mixed_gram_);
  const Eigen::Matrix<double, kLinear, kNonlinear> cross = slope.lazyProduct(s_inverse);
  fit.inverse.resize(kAll, kAll);
  fit.inverse.template block<kLinear, kLinear>(0, 0) =
      g_inverse + cross.lazyProduct(slope.transpose());
  fit.inverse.template block<kLinear, kNonlinear>(0, kLinear) = -cross;
  fit.inverse.template block<kNonlinear, kLinear>(kLinear, 0) = -cross.transpose();
  fit.inverse.template block<kNonlinear, kNonlinear>(kLinear, kLinear) = s_inverse;
}

template <int K>
void fit_joint(const GroupSamples& samples, DampedSinusoid* pulses, int max_iterations,
               GroupFit& fit) {
  VarPro<K> problem(samples, pulses);
  fit.status = problem.search(max_iterations, fit);
  if (fit.status == FitStatus::kConverged) problem.finish(fit);
}

}  // namespace

void fit_pulses(const GroupSamples& samples, DampedSinusoid* pulses, int count, int max_iterations,
                GroupFit& fit) {
  fit.offender = count - 1;
  switch (count) {
    case 1:
      return fit_joint<1>(samples, pulses, max_iterations, fit);
    case 2:
      return fit_joint<2>(samples, pulses, max_iterations, fit);
    default:
      return fit_joint<3>(samples, pulses, max_iterations, fit);
  }
}

double evaluate(const DampedSinusoid* pulses, int count, double gamma, int index) {
  double sum = gamma;
  for (int k = 0; k < count; ++k) {
    const int i = index - pulses[k].start;
    if (i < 0) continue;
    const double angle = pulses[k].omega * i;
    sum += std::exp(-pulses[k].alpha * i) *
           (pulses[k].cosine * std::cos(angle) + pulses[k].sine * std::sin(angle));
  }
  return sum;
}

}  // namespace gprodom::gpr
