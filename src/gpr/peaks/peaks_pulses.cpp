#include "gpr/peaks/peaks_pulses.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace gprodom::gpr {
namespace {

constexpr double kTwoPi = 6.28318530717958647692;
constexpr double kMinOmega = kTwoPi / 25.0;  // rad per sample: the gates of a joint fit are bounded
constexpr double kMaxOmega = kTwoPi / 3.0;
constexpr double kMinSeparation = 0.75;  // of a period
constexpr double kMaxValley = 0.75;      // of the lower of two maxima, for them to be two pulses
constexpr int kMaxHalfWidth = 3;         // of the running mean
constexpr float kDominant = 0.5F;  // of the largest envelope; samples above it give the frequency
constexpr double kMaxDetuning = 1.6;  // of a pulse's start frequency from the dominant one

// Sums for the ratio exp(2 (-alpha + j omega)) that best takes each z[i] to z[i + 2] in least
// squares. Of white noise the analytic signal is uncorrelated at even lags, so noise does not pull
// the frequency.
struct StepSums {
  static constexpr int kLag = 2;
  double real = 0.0, imaginary = 0.0, energy = 0.0;

  void add(const AnalyticSignal& signal, int i) {
    const double a = signal.real[i], b = signal.imaginary[i];
    const double c = signal.real[i + kLag], d = signal.imaginary[i + kLag];
    real += c * a + d * b;
    imaginary += d * a - c * b;
    energy += a * a + b * b;
  }
  double omega() const {
    const double angle = std::atan2(imaginary, real);
    return (angle < 0.0 ? angle + kTwoPi : angle) / kLag;
  }
  double alpha() const {
    const double power = real * real + imaginary * imaginary;
    return power > 0.0 ? -0.5 / kLag * std::log(power / (energy * energy)) : 0.0;
  }
};

// Mean instantaneous frequency where the envelope is high.
double dominant_omega(const AnalyticSignal& signal) {
  const std::vector<float>& envelope = signal.envelope;
  const Eigen::Map<const Eigen::ArrayXf> values(envelope.data(),
                                                static_cast<Eigen::Index>(envelope.size()));
  const float high = kDominant * values.maxCoeff();
  StepSums sums;
  for (int i = 0; i + StepSums::kLag < static_cast<int>(envelope.size()); ++i) {
    if (envelope[i] >= high) sums.add(signal, i);
  }
  return std::clamp(sums.omega(), kMinOmega, kMaxOmega);
}

// Smooths the envelope by two running means over an odd number of samples near a quarter of a
// period. This removes the ripple from noise outside the pulse's band. Beyond the ends are zeros.
void smooth(AnalyticSignal& signal, double period) {
  const auto size = static_cast<Eigen::Index>(signal.envelope.size());
  const int half = std::min(static_cast<int>(period / 8.0), kMaxHalfWidth);
  const auto share = 1.0F / static_cast<float>(2 * half + 1);
  signal.padded.resize(size + 2 * kMaxHalfWidth);
  signal.smoothed.resize(signal.envelope.size());
  Eigen::Map<Eigen::ArrayXf> padded(signal.padded.data(), size + 2 * kMaxHalfWidth);
  Eigen::Map<Eigen::ArrayXf> smoothed(signal.smoothed.data(), size);
  smoothed = Eigen::Map<const Eigen::ArrayXf>(signal.envelope.data(), size);
  padded.head(kMaxHalfWidth).setZero();
  padded.tail(kMaxHalfWidth).setZero();
  for (int pass = 0; pass < 2; ++pass) {
    padded.segment(kMaxHalfWidth, size) = share * smoothed;
    smoothed = padded.segment(kMaxHalfWidth, size);
    for (int k = 1; k <= half; ++k) {
      smoothed += padded.segment(kMaxHalfWidth - k, size) + padded.segment(kMaxHalfWidth + k, size);
    }
  }
}

int minimum_between(const std::vector<float>& envelope, int begin, int end) {
  const auto first = envelope.begin();
  return static_cast<int>(std::min_element(first + begin, first + end) - first);
}

// Two maxima are two pulses if far enough apart and with a valley between them.
bool apart(const std::vector<float>& envelope, const Pulse& before, const Pulse& after,
           double separation) {
  if (after.maximum - before.maximum < separation) return false;
  const int valley = minimum_between(envelope, before.maximum, after.maximum);
  return envelope[valley] <= kMaxValley * std::min(before.height, after.height);
}

void find_maxima(const std::vector<float>& envelope, double threshold, double separation,
                 std::vector<Pulse>& pulses) {
  const int size = static_cast<int>(envelope.size());
  for (int i = 1; i + 1 < size; ++i) {
    const float height = envelope[i];
    if (height < threshold || height <= envelope[i - 1] || height < envelope[i + 1]) {
      continue;
    }
    Pulse pulse;
    pulse.maximum = i;
    pulse.height = height;
    if (pulses.empty() || apart(envelope, pulses.back(), pulse, separation)) {
      pulses.push_back(pulse);
    } else if (height > pulses.back().height) {
      pulses.back() = pulse;
    }
  }
}

void set_gate_and_start(const AnalyticSignal& signal, double gate_periods, Pulse& pulse) {
  const int size = static_cast<int>(signal.envelope.size());
  const int period = static_cast<int>(std::lround(kTwoPi / pulse.centre_omega));
  const int end = std::min({pulse.maximum + period, pulse.valley, size - StepSums::kLag});
  StepSums sums;
  for (int i = pulse.maximum; i < end; ++i) sums.add(signal, i);
  pulse.omega = std::clamp(end > pulse.maximum + 2 ? sums.omega() : pulse.centre_omega,
                           pulse.centre_omega / kMaxDetuning, pulse.centre_omega * kMaxDetuning);
  pulse.alpha = std::clamp(sums.alpha(), 0.02 * pulse.omega, 0.5 * pulse.omega);
  const int gate = static_cast<int>(std::floor(gate_periods * kTwoPi / pulse.omega + 0.5));
  pulse.gate_end = std::min(pulse.maximum + gate + 1, size);
}

}  // namespace

void find_pulses(AnalyticSignal& signal, double threshold, double gate_periods,
                 std::vector<Pulse>& pulses) {
  const int size = static_cast<int>(signal.envelope.size());
  pulses.clear();
  pulses.reserve(signal.envelope.size() / 2 + 1);
  if (size < 3) return;
  const double omega = dominant_omega(signal);
  const double period = kTwoPi / omega;
  smooth(signal, period);
  find_maxima(signal.smoothed, threshold, kMinSeparation * period, pulses);
  for (std::size_t k = 0; k < pulses.size(); ++k) {
    const int next = k + 1 < pulses.size() ? pulses[k + 1].maximum : size;
    pulses[k].centre_omega = omega;
    pulses[k].valley = minimum_between(signal.smoothed, pulses[k].maximum, next);
    set_gate_and_start(signal, gate_periods, pulses[k]);
  }
}

EnvelopeMaximum refine_maximum(const std::vector<float>& envelope, int maximum) {
  const double here = envelope[maximum];
  const double before = envelope[maximum - 1];
  const double after = envelope[maximum + 1];
  const double curvature = before - 2.0 * here + after;
  if (curvature >= 0.0) return {static_cast<double>(maximum), here};
  const double shift = 0.5 * (before - after) / curvature;
  return {maximum + shift, here - 0.25 * (before - after) * shift};
}

}  // namespace gprodom::gpr
