#include "gpr/motion/window_statistics.h"

#include <algorithm>
#include <cmath>

#include "gpr/kernels/add_multiple.h"

namespace gprodom::gpr {
namespace {

constexpr int kMinTraces = 4;
constexpr int kAutocorrelationLags = 8;

// Legendre polynomials 0, 1, ... over the trace, by their three-term recurrence.
void fill_legendre(Eigen::MatrixXf& basis) {
  const Eigen::VectorXf x = Eigen::VectorXf::LinSpaced(basis.rows(), -1.0f, 1.0f);
  basis.col(0).setOnes();
  basis.col(1) = x;
  for (Eigen::Index k = 2; k < basis.cols(); ++k) {
    const auto degree = static_cast<float>(k);
    basis.col(k) = ((2.0f * degree - 1.0f) * x.array() * basis.col(k - 1).array() -
                    (degree - 1.0f) * basis.col(k - 2).array()) /
                   degree;
  }
}

// Of order 1 to 3. The first is a central difference of sixth order: a second-order one is a
// quarter short at a fifth of the sampling rate, which leaves more than the noise beside strong
// reflections.
void derive(int order, const Eigen::VectorXf& s, Eigen::Ref<Eigen::VectorXf> out) {
  const Eigen::Index reach = order == 1 ? 3 : order - 1, n = s.size() - 2 * reach;
  const auto at = [&](Eigen::Index lag) { return s.segment(reach + lag, n); };
  out.setZero();
  auto middle = out.segment(reach, n);
  if (order == 1)
    middle = 0.75f * (at(1) - at(-1)) - 0.15f * (at(2) - at(-2)) + (at(3) - at(-3)) / 60.0f;
  else if (order == 2)
    middle = at(-1) - 2.0f * at(0) + at(1);
  else
    middle = 0.5f * (at(2) - at(-2)) - (at(1) - at(-1));
}

}  // namespace

void WindowAnalyser::resize(Eigen::Index samples, Eigen::Index traces) {
  if (polynomials_.rows() != samples) {
    polynomials_.resize(samples, kPolynomials);
    fill_legendre(polynomials_);
    nuisances_.resize(samples, kNuisances);
    used_.resize(0);
    mean_.resize(samples);
    contrast_.resize(samples);
  }
  if (residual_.rows() != samples || residual_.cols() < traces) {
    residual_.resize(samples, traces);
    cumulative_.resize(samples, traces + 1);
  }
}

// Gram-Schmidt, twice for orthogonality in single precision; returns how many are independent.
int WindowAnalyser::build_nuisances(const Eigen::Ref<const Eigen::VectorXf>& used) {
  // Those of the polynomials depend on nothing but the samples used, which are mostly the same.
  const bool as_before = used_.size() == used.size() && used_ == used;
  used_ = used;
  int count = as_before ? polynomials_used_ : 0;
  for (int k = as_before ? kPolynomials : 0; k < kNuisances; ++k) {
    if (k == kPolynomials) polynomials_used_ = count;
    auto column = nuisances_.col(count);
    if (k < kPolynomials) {
      column = polynomials_.col(k);
    } else if (k == kPolynomials) {
      column = mean_;
    } else {
      derive(k - kPolynomials, mean_, column);
    }
    column.array() *= used.array();
    const float before = column.squaredNorm();
    for (int pass = 0; pass < 2; ++pass) {
      for (int j = 0; j < count; ++j) {
        add_multiple(-nuisances_.col(j).dot(column), &nuisances_(0, j), column.size(),
                     column.data());
      }
    }
    const float after = column.squaredNorm();
    if (after > 1e-6f * before) {
      column /= std::sqrt(after);
      ++count;
    }
  }
  return count;
}

void WindowAnalyser::take_out_nuisances(int count, Eigen::Ref<Eigen::VectorXf> trace) const {
  for (int j = 0; j < count; ++j) {
    add_multiple(-nuisances_.col(j).dot(trace), &nuisances_(0, j), trace.size(), trace.data());
  }
}

// The largest |sum_i c_i R_i|^2 over the contrasts c.
double WindowAnalyser::largest_contrast(int n) {
  double largest = 0.0;
  contrast_.setZero();
  const double middle = 0.5 * (n - 1);
  double norm = 0.0;
  cumulative_.col(0).setZero();
  for (int i = 0; i < n; ++i) {
    cumulative_.col(i + 1) = cumulative_.col(i) + residual_.col(i);
    contrast_ += static_cast<float>(i - middle) * residual_.col(i);
    norm += (i - middle) * (i - middle);
  }
  largest = contrast_.squaredNorm() / norm;
  for (int k = 1; k <= std::min(3, n / 2); ++k) {
    // 1/k on k traces, -1/(n-k) on the others, over its norm sqrt(1/k + 1/(n-k)).
    const auto a = static_cast<float>(1.0 / k + 1.0 / (n - k));
    const auto b = static_cast<float>(1.0 / (n - k));
    contrast_ = a * cumulative_.col(k) - b * cumulative_.col(n);
    largest = std::max(largest, static_cast<double>(contrast_.squaredNorm() / a));
    contrast_ = (a - b) * cumulative_.col(n) - a * cumulative_.col(n - k);
    largest = std::max(largest, static_cast<double>(contrast_.squaredNorm() / a));
  }
  return largest;
}

double WindowAnalyser::mean_square_step(int n) const {
  return (residual_.middleCols(1, n - 1) - residual_.leftCols(n - 1)).squaredNorm() / (n - 1);
}

// Fraction of the residual's samples that are worth a degree of freedom each: 1 for white noise,
// 1 / sum_k rho_k^2 for coloured (Bartlett).
double WindowAnalyser::whiteness(int n) const {
  const Eigen::Index samples = residual_.rows();
  const double power = residual_.leftCols(n).squaredNorm();
  double sum = 1.0;
  for (int lag = 1; lag <= std::min<int>(kAutocorrelationLags, static_cast<int>(samples) - 1);
       ++lag) {
    double product = 0.0;
    for (int i = 0; i < n; ++i) {
      product += residual_.col(i).head(samples - lag).dot(residual_.col(i).tail(samples - lag));
    }
    sum += 2.0 * (product / power) * (product / power);
  }
  return 1.0 / sum;
}

double WindowAnalyser::difference(const Eigen::VectorXf& other,
                                  const Eigen::Ref<const Eigen::VectorXf>& used) {
  const int nuisances = build_nuisances(used);
  contrast_ = (mean_ - other).cwiseProduct(used);
  take_out_nuisances(nuisances, contrast_);
  return contrast_.squaredNorm() / std::max(1.0, static_cast<double>(used.sum()) - nuisances);
}

WindowStatistics WindowAnalyser::analyse(const Eigen::Ref<const Eigen::MatrixXf>& traces,
                                         const Eigen::Ref<const Eigen::VectorXf>& weight,
                                         const Eigen::Ref<const Eigen::VectorXf>& used) {
  WindowStatistics result;
  const int n = static_cast<int>((weight.array() > 0.0f).count());
  if (n < kMinTraces || traces.rows() < 4 * kNuisances) return result;
  resize(traces.rows(), traces.cols());

  const float total_weight = weight.sum();
  mean_.setZero();
  for (Eigen::Index i = 0; i < traces.cols(); ++i) {
    if (weight[i] > 0.0f) mean_ += (weight[i] / total_weight) * traces.col(i);
  }
  const int nuisances = build_nuisances(used);
  result.samples = static_cast<double>(used.sum()) - nuisances;
  if (result.samples < 8.0) return result;

  double sum = 0.0, largest = 0.0;
  int outlier = -1;
  for (Eigen::Index i = 0, k = 0; i < traces.cols(); ++i) {
    if (weight[i] <= 0.0f) continue;
    auto r = residual_.col(k++);
    r.array() = std::sqrt(weight[i]) * (traces.col(i) - mean_).array() * used.array();
    take_out_nuisances(nuisances, r);
    const double energy = r.squaredNorm();
    sum += energy;
    if (energy > largest) {
      largest = energy;
      outlier = static_cast<int>(i);
    }
  }
  result.traces = n;
  result.variance = sum / (result.samples * (n - 1));
  result.trend = sum > 0.0 ? largest_contrast(n) / (result.samples * result.variance) : 0.0;
  result.step = 0.5 * mean_square_step(n) / result.samples;
  const double offset = mean_.dot(used) / used.sum();
  result.signal =
      ((mean_.array() - static_cast<float>(offset)) * used.array()).square().sum() / used.sum();
  if (largest > 0.5 * sum) result.outlier = outlier;
  if (sum > 0.0) result.white_samples = result.samples * whiteness(n);
  return result;
}

}  // namespace gprodom::gpr
