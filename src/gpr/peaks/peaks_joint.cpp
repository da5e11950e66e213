#include "gpr/peaks/peaks_joint.h"

#include <algorithm>
#include <cmath>

#include "gpr/peaks/peaks_covariance.h"

namespace gprodom::gpr {
namespace {

constexpr double kSupport = 2.5;  // standard deviations within which a sample follows the curve
constexpr int kMinGate = 6;       // samples of a pulse's own

// P(F(4, freedom) > f), in closed form since 4 is even.
double f_survival(double f, int freedom) {
  const double half = 0.5 * freedom;
  const double x = freedom / (freedom + 4.0 * f);
  return std::pow(x, half) * (1.0 + half * (1.0 - x));
}

// C and S of a pulse at i samples from its start, i of either sign.
struct Basis {
  double cosine, sine;
};
Basis basis(const DampedSinusoid& pulse, double i) {
  const double decay = std::exp(-pulse.alpha * i);
  return {decay * std::cos(pulse.omega * i), decay * std::sin(pulse.omega * i)};
}

// Moves the origin of a pulse's curve; the curve stays.
void move_start(DampedSinusoid& pulse, int start) {
  const Basis at = basis(pulse, start - pulse.start);
  const double a = pulse.cosine, b = pulse.sine;
  pulse.cosine = a * at.cosine + b * at.sine;
  pulse.sine = b * at.cosine - a * at.sine;
  pulse.start = start;
}

}  // namespace

JointFit::JointFit(const PeakOptions& options) : options_(options) {
  for (int freedom = 1; freedom < kMaxGroupSamples; ++freedom) {
    double low = 0.0, high = 1.0;
    while (f_survival(high, freedom) > options.significance) high *= 2.0;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (low + high);
      (f_survival(middle, freedom) > options.significance ? low : high) = middle;
    }
    critical_[freedom] = high;
  }
  critical_[0] = critical_[1];
}

void JointFit::run(const float* trace, const std::vector<Pulse>& all, int begin, int end,
                   std::vector<Peak>& peaks, PeakCounts& counts) {
  trace_ = trace;
  all_ = &all;
  peaks_ = &peaks;
  counts_ = &counts;
  base_ = begin;
  use_.fill(Use::kFitted);
  fit_range(begin, end);
}

void JointFit::fit_range(int begin, int end) {
  while (true) {
    start(begin, end);
    if (count_ == 0) return;
    if (!fit() || (widen_gates() && !fit())) {
      const int blamed = origin_[fit_.offender];
      if (fit_.status == FitStatus::kTooFewSamples && count_ > 1) {
        leave_out_lower_neighbour();
        continue;
      }
      ++(fit_.status == FitStatus::kOutOfBounds ? counts_->out_of_bounds : counts_->not_converged);
      fit_range(begin, blamed);
      fit_range(blamed + 1, end);
      return;
    }
    const int least = least_significant();
    if (least < 0) break;
    use_[origin_[least] - base_] = Use::kInsignificant;
    ++counts_->insignificant;
  }
  for (int k = 0; k < count_; ++k) accept(k);
}

// Two pulses that are too close for two gates count as one: the lower one is dropped.
void JointFit::leave_out_lower_neighbour() {
  const int k = fit_.offender + 1 < count_ ? fit_.offender : fit_.offender - 1;
  const auto height = [this](int j) { return (*all_)[origin_[j]].height; };
  const int lower = height(k) < height(k + 1) ? k : k + 1;
  use_[origin_[lower] - base_] = Use::kInsignificant;
  ++counts_->insignificant;
}

void JointFit::start(int begin, int end) {
  const auto& all = *all_;
  count_ = 0;
  for (int j = begin; j < end; ++j) {
    if (use_[j - base_] != Use::kFitted) continue;
    const Pulse& candidate = all[j];
    DampedSinusoid& pulse = pulse_[count_];
    pulse.start = candidate.maximum;
    pulse.alpha = candidate.alpha;
    pulse.omega = candidate.omega;
    pulse.omega_min = 0.5 * candidate.centre_omega;
    pulse.omega_max = 2.0 * candidate.centre_omega;
    pulse.alpha_min = -0.1 * candidate.centre_omega;
    pulse.alpha_max = candidate.centre_omega;
    int last = j;  // dropped pulses have no valley of their own
    while (last + 1 < end && use_[last + 1 - base_] == Use::kInsignificant) ++last;
    stop_[count_] = std::min(candidate.gate_end, all[last].valley + 1);
    origin_[count_] = j;
    ++count_;
  }
}

void JointFit::gather() {
  samples_.size = 0;
  int from = 0;
  for (int k = 0; k < count_; ++k) {
    for (from = std::max(from, pulse_[k].start);
         from < stop_[k] && samples_.size < kMaxGroupSamples - 1; ++from) {
      samples_.index[samples_.size] = from;
      samples_.value[samples_.size] = trace_[from];
      ++samples_.size;
    }
  }
}

bool JointFit::fit() {
  for (int k = 0; k < count_; ++k) {
    if (stop_[k] - pulse_[k].start < kMinGate) {
      fit_.status = FitStatus::kTooFewSamples;
      fit_.offender = k;
      return false;
    }
  }
  gather();
  fit_pulses(samples_, pulse_.data(), count_, options_.max_iterations, fit_);
  if (fit_.status != FitStatus::kConverged) return false;

  // A known noise is used unless the residual contradicts it (three standard deviations of chi^2).
  // An estimated noise is inflated by the variance of Student's t for its degrees of freedom.
  const double freedom = fit_.freedom;
  const double known = options_.noise_sigma * options_.noise_sigma;
  const double own = fit_.residual_sum / freedom;
  const bool believed = known > 0.0 && own <= known * (1.0 + 3.0 * std::sqrt(2.0 / freedom));
  variance_ = believed ? known : own * (freedom > 2.0 ? freedom / (freedom - 2.0) : freedom);
  return true;
}

// Error of predicting a sample from the first `count` pulses over its standard deviation, from
// noise and from the errors of the parameters. The curve of the last of them is carried on before
// its start.
double JointFit::prediction_error(int count, int sample) const {
  using Slope = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxGroupParameters, 1>;
  const int linear = 2 * count_ + 1;
  Slope slope = Slope::Zero(linear + 2 * count_);
  slope[linear - 1] = 1.0;
  double value = fit_.gamma;
  for (int k = 0; k < count; ++k) {
    const DampedSinusoid& pulse = pulse_[k];
    const double i = sample - pulse.start;
    const Basis at = basis(pulse, i);
    const double curve = pulse.cosine * at.cosine + pulse.sine * at.sine;
    value += curve;
    slope[2 * k] = at.cosine;
    slope[2 * k + 1] = at.sine;
    slope[linear + 2 * k] = -i * curve;
    slope[linear + 2 * k + 1] = i * (pulse.sine * at.cosine - pulse.cosine * at.sine);
  }
  const double variance = variance_ * (1.0 + slope.dot(fit_.inverse.lazyProduct(slope)));
  return std::abs(trace_[sample] - value) / std::sqrt(variance);
}

// Whether a sample belongs to the pulses up to k rather than to those before k alone.
bool JointFit::belongs(int k, int sample) const {
  const double with = prediction_error(k + 1, sample);
  return with <= kSupport && with < prediction_error(k, sample);
}

// Extends gates over the samples that the curves predict; true if one grew. It uses the fitted
// curves as they are and moves their origins only at the end.
bool JointFit::widen_gates() {
  bool grown = false;
  std::array<int, kMaxJointPulses> start{};
  for (int k = 0; k < count_; ++k) {
    const DampedSinusoid& pulse = pulse_[k];
    const int reach = pulse.start - static_cast<int>(M_PI / pulse.omega);
    const int limit = std::max(k > 0 ? stop_[k - 1] : 0, reach);
    start[k] = pulse.start;
    while (start[k] > limit && belongs(k, start[k] - 1)) --start[k];
    grown |= start[k] < pulse.start;
    if (k == 0) continue;
    for (int& stop = stop_[k - 1]; stop < start[k] && prediction_error(k, stop) <= kSupport;
         ++stop) {
      grown = true;
    }
  }
  for (int k = 0; k < count_; ++k) {
    if (start[k] < pulse_[k].start) move_start(pulse_[k], start[k]);
  }
  return grown;
}

// The pulse that contributes least, if it fails the F-test; else -1.
int JointFit::least_significant() const {
  const auto end = fit_.contribution.begin() + count_;
  const auto least = std::min_element(fit_.contribution.begin(), end);
  const double f = *least / 4.0 / (fit_.residual_sum / fit_.freedom);
  const bool fails = !(f >= critical_[std::clamp(fit_.freedom, 0, kMaxGroupSamples - 1)]);
  return fails ? static_cast<int>(least - fit_.contribution.begin()) : -1;
}

void JointFit::accept(int k) {
  if (!(pulse_[k].alpha > 0.0)) {
    ++counts_->out_of_bounds;
    return;
  }
  Peak peak = peak_of_fit(pulse_.data(), count_, k, fit_, variance_);
  peak.gate_end = stop_[k];
  peak.joint = count_;

  double misfit = 0.0, energy = 0.0;
  for (int row = 0; row < samples_.size; ++row) {
    const int i = samples_.index[row];
    if (i < peak.gate_begin || i >= peak.gate_end) continue;
    const double signal = samples_.value[row] - peak.gamma;
    misfit += fit_.residual[row] * fit_.residual[row];
    energy += signal * signal;
  }
  const double share = static_cast<double>(fit_.freedom) / samples_.size;
  const double noise =
      options_.noise_sigma * options_.noise_sigma * share * (peak.gate_end - peak.gate_begin);
  const bool fits = misfit - noise <= options_.max_residual * energy;
  if (!fits || !peak.covariance.allFinite() || peak.sample > peak.gate_end) {
    ++counts_->misfit;
    return;
  }
  peak.residual = std::sqrt(misfit / energy);
  ++counts_->accepted;
  peaks_->push_back(peak);
}

}  // namespace gprodom::gpr
