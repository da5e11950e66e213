#include "gpr/peaks/peaks.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "gpr/allocation_count.h"
#include "gpr/damped_pulses.h"
#include "gpr/peaks/peaks_covariance.h"
#include "gpr/peaks/peaks_envelope.h"
#include "gpr/peaks/peaks_varpro.h"
#include "support/derivative.h"

namespace gprodom::gpr {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

TEST(Envelope, IsThatOfAModulatedTone) {
  std::vector<float> trace(kTraceSamples);
  const auto envelope = [](int i) { return std::exp(-std::pow((i - 90) / 25.0, 2)); };
  for (int i = 0; i < kTraceSamples; ++i) {
    trace[at(i)] = static_cast<float>(5.0 + envelope(i) * std::cos(kPulseOmega * i + 1.0));
  }
  AnalyticSignal signal;
  analytic_signal(trace.data(), trace.size(), signal);
  for (int i = 30; i < 150; ++i) EXPECT_NEAR(signal.envelope[at(i)], envelope(i), 0.015);
}

// Start values for pulses, 10 % off.
std::vector<DampedSinusoid> starts(const std::vector<TruePulse>& pulses) {
  std::vector<DampedSinusoid> out;
  for (const TruePulse& pulse : pulses) {
    DampedSinusoid start;
    start.start = pulse.onset;
    start.alpha = 1.1 * pulse.alpha;
    start.omega = 0.95 * pulse.omega;
    start.alpha_min = -0.1;
    start.alpha_max = 1.0;
    start.omega_min = 0.3;
    start.omega_max = 1.3;
    out.push_back(start);
  }
  return out;
}

GroupSamples exact_samples(const std::vector<TruePulse>& pulses, double gamma, int end) {
  GroupSamples samples;
  for (int i = pulses.front().onset; i < end; ++i, ++samples.size) {
    samples.index[at(samples.size)] = i;
    samples.value[at(samples.size)] = model(pulses, gamma, i);
  }
  return samples;
}

TEST(VarPro, FindsExactParametersOfThreeOverlappingPulses) {
  std::mt19937 random(1);
  for (int draw = 0; draw < 50; ++draw) {
    const std::vector<TruePulse> pulses = {random_pulse(random, 20), random_pulse(random, 33, 0.8),
                                           random_pulse(random, 47, 1.3)};
    auto fitted = starts(pulses);
    GroupFit fit;
    fit_pulses(exact_samples(pulses, 0.2, 63), fitted.data(), 3, 30, fit);
    ASSERT_EQ(fit.status, FitStatus::kConverged) << draw;
    EXPECT_NEAR(fit.gamma, 0.2, 1e-5);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(fitted[k].alpha, pulses[k].alpha, 1e-5);
      EXPECT_NEAR(fitted[k].omega, pulses[k].omega, 1e-5);
      EXPECT_NEAR(fitted[k].cosine, pulses[k].beta * std::cos(pulses[k].phi), 1e-5);
      EXPECT_NEAR(fitted[k].sine, -pulses[k].beta * std::sin(pulses[k].phi), 1e-5);
    }
  }
}

// The covariance is that of the map from data to estimate, here by differences: every sample moved,
// the fit done again.
TEST(VarPro, CovarianceIsThatOfTheEstimatesDerivative) {
  std::mt19937 random(2);
  const std::vector<TruePulse> pulses = {random_pulse(random, 20), random_pulse(random, 35)};
  const GroupSamples exact = exact_samples(pulses, 0.1, 51);
  const auto estimate = [&](const GroupSamples& samples) {
    auto fitted = starts(pulses);
    GroupFit fit;
    fit_pulses(samples, fitted.data(), 2, 50, fit);
    EXPECT_EQ(fit.status, FitStatus::kConverged);
    return peak_of_fit(fitted.data(), 2, 1, fit, 1.0);
  };
  const auto vector = [](const Peak& p) {
    Eigen::Matrix<double, 7, 1> v;
    v << p.sample, p.amplitude, p.alpha, p.beta, p.gamma, p.omega, p.phi;
    return v;
  };
  const Eigen::MatrixXd J = numeric_jacobian(exact.size, 2e-3, [&](const Eigen::VectorXd& d) {
    GroupSamples moved = exact;
    for (int row = 0; row < exact.size; ++row) moved.value[at(row)] += d[row];
    return vector(estimate(moved));
  });
  const PeakCovariance numeric = J * J.transpose();
  const PeakCovariance analytic = estimate(exact).covariance;
  const Eigen::Matrix<double, 7, 1> sigma = analytic.diagonal().cwiseSqrt();
  EXPECT_LT(((numeric - analytic).array() / (sigma * sigma.transpose()).array()).abs().maxCoeff(),
            0.03);
}

// Whatever the input, a returned fit is reliable.
TEST(PeakExtractor, ReturnsOnlySignificantFits) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 1.0F);
  std::uniform_int_distribution<int> place(0, kTraceSamples - 1);
  const PeakOptions options;
  PeakExtractor extractor(options);
  std::vector<float> trace(kTraceSamples);
  std::size_t peaks_seen = 0;
  for (int draw = 0; draw < 900; ++draw) {
    for (float& value : trace) value = noise(random);
    const int from = place(random);
    for (int i = from; i < kTraceSamples; ++i) {
      if (draw % 3 == 1) trace[at(i)] += 20.0F;                                   // a step
      if (draw % 3 == 2) trace[at(i)] = 1e4F * static_cast<float>(draw % 2) - 1;  // clipped
    }
    for (const Peak& peak : extractor.extract(trace.data(), trace.size())) {
      ++peaks_seen;
      EXPECT_GT(peak.alpha, 0.0);
      EXPECT_GE(peak.sample, peak.gate_begin);
      EXPECT_LE(peak.sample, peak.gate_end);
      EXPECT_LE(peak.residual * peak.residual, options.max_residual);
      EXPECT_TRUE(std::isfinite(peak.amplitude));
      const Eigen::Matrix2d covariance = peak.covariance.topLeftCorner<2, 2>();
      EXPECT_EQ(Eigen::LLT<Eigen::Matrix2d>(covariance).info(), Eigen::Success);
    }
  }
  const PeakCounts& counts = extractor.counts();
  EXPECT_EQ(counts.accepted, peaks_seen);
  EXPECT_GT(counts.pulses, 2 * counts.accepted);  // noise is mostly refused
  EXPECT_EQ(counts.pulses, counts.accepted + counts.insignificant + counts.not_converged +
                               counts.out_of_bounds + counts.misfit);
}

TEST(PeakExtractor, RejectsPulsesWithoutDecayAndNonFiniteTraces) {
  PeakExtractor extractor;
  std::vector<float> trace(kTraceSamples, 0.0F);
  EXPECT_TRUE(extractor.extract(trace.data(), trace.size()).empty());  // nothing there
  for (int i = 0; i < kTraceSamples; ++i) {  // a tone of constant height to the trace's end
    trace[at(i)] = static_cast<float>(std::exp(0.01 * i) * std::cos(kPulseOmega * i));
  }
  EXPECT_TRUE(extractor.extract(trace.data(), trace.size()).empty());
  trace[100] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(extractor.extract(trace.data(), trace.size()).empty());
  trace[100] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(extractor.extract(trace.data(), trace.size()).empty());
  EXPECT_TRUE(extractor.extract(trace.data(), 2).empty());  // shorter than any pulse
}

TEST(PeakExtractor, WithoutTheFitGivesTheEnvelopesMaximum) {
  PeakOptions options;
  options.fit = false;
  PeakExtractor extractor(options);
  std::vector<float> trace(kTraceSamples);
  for (int i = 0; i < kTraceSamples; ++i) {
    trace[at(i)] = static_cast<float>(2.0 * std::exp(-std::pow((i - 90.3) / 20.0, 2)) *
                                      std::cos(kPulseOmega * i));
  }
  const auto& peaks = extractor.extract(trace.data(), trace.size());
  ASSERT_EQ(peaks.size(), 1U);
  EXPECT_NEAR(peaks[0].sample, 90.3, 0.1);
  EXPECT_NEAR(peaks[0].amplitude, 2.0, 0.05);
  EXPECT_EQ(peaks[0].joint, 0);
}

TEST(PeakExtractor, AllocatesNothingOnceWarm) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer replaces malloc";
  std::mt19937 random(4);
  std::vector<std::vector<float>> traces;
  for (int i = 0; i < 50; ++i) {
    traces.push_back(noisy_trace(
        {random_pulse(random, 20 + i), random_pulse(random, 38 + i), random_pulse(random, 110)},
        0.0, 0.02 * (i % 5), random));
  }
  for (const bool fit : {true, false}) {
    PeakOptions options;
    options.fit = fit;
    PeakExtractor extractor(options);
    extractor.extract(traces[0].data(), traces[0].size());
    const std::size_t before = allocation_count();
    for (const auto& trace : traces) extractor.extract(trace.data(), trace.size());
    EXPECT_EQ(allocation_count(), before);
    EXPECT_GT(extractor.counts().accepted, 50U);
  }
}

TEST(PeakOptions, OutOfRangeIsRefused) {
  for (const auto& spoil : std::vector<void (*)(PeakOptions&)>{
           [](PeakOptions& o) { o.max_joint = 4; }, [](PeakOptions& o) { o.noise_sigma = -1.0; },
           [](PeakOptions& o) { o.significance = 0.0; }, [](PeakOptions& o) { o.gate_periods = 9; },
           [](PeakOptions& o) { o.min_relative = NAN; }}) {
    PeakOptions options;
    spoil(options);
    EXPECT_THROW(PeakExtractor{options}, std::invalid_argument);
  }
}

TEST(PeakDepth, TravelTimeGivesDepthAndRow) {
  const double time = travel_time(60.5, 2e-10, 1.1e-9);
  EXPECT_NEAR(time, 11e-9, 1e-18);
  EXPECT_NEAR(depth_of(time, 1e8), 0.55, 1e-9);
  EXPECT_EQ(depth_row(0.55, 1.0, 50), 27);
  EXPECT_EQ(depth_row(0.0, 1.0, 50), 0);
  EXPECT_EQ(depth_row(-1e-9, 1.0, 50), -1);
  EXPECT_EQ(depth_row(1.0, 1.0, 50), -1);
}

// Peaks against the Cramer-Rao bound. SNR is beta over the noise's standard deviation.
//
// The phase is random, so a maximum may lie within the noise of the onset. Then the data do not
// show whether it is the first one. So errors are taken to the nearest maximum of the true curve,
// with that maximum's bound, and a separate limit holds for how often it was not the first one.
constexpr double kGamma = 0.3;
constexpr int kGate = 16;  // samples from the onset to 1.5 periods after it

// Sums over draws: squared errors and squared bounds of time and amplitude, normalised errors.
struct Tally {
  int draws = 0, found = 0, later_maximum = 0;
  double time = 0.0, time_bound = 0.0, amplitude = 0.0, amplitude_bound = 0.0, nees = 0.0;

  void add(const Peak& peak, int onset, const PeakBound& truth) {
    const Eigen::Vector2d error(peak.sample - onset - truth.time, peak.amplitude - truth.amplitude);
    time += error[0] * error[0];
    time_bound += truth.time_sigma * truth.time_sigma;
    amplitude += error[1] * error[1];
    amplitude_bound += truth.amplitude_sigma * truth.amplitude_sigma;
    const Eigen::Matrix2d covariance = peak.covariance.topLeftCorner<2, 2>();
    nees += error.dot(covariance.inverse() * error);
  }
  double time_ratio() const { return std::sqrt(time / time_bound); }
  double amplitude_ratio() const { return std::sqrt(amplitude / amplitude_bound); }
};

// The peak whose gate begins nearest to an onset, if within half a period.
std::optional<Peak> peak_at(const std::vector<Peak>& peaks, int onset) {
  std::optional<Peak> best;
  for (const Peak& peak : peaks) {
    const int distance = std::abs(peak.gate_begin - onset);
    if (distance <= 5 && (!best || distance < std::abs(best->gate_begin - onset))) best = peak;
  }
  return best;
}

double first_maximum(const TruePulse& pulse) {
  double place = maximum_near(pulse, 0.0);
  if (place < 0.0) place = maximum_near(pulse, place + 2.0 * kPi / pulse.omega);
  return place;
}

Tally single_pulses(double snr, int draws, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> onsets(40, 120);
  PeakOptions options;
  options.noise_sigma = 1.0 / snr;
  PeakExtractor extractor(options);
  Tally tally;
  for (; tally.draws < draws; ++tally.draws) {
    const std::vector<TruePulse> pulses = {random_pulse(random, onsets(random))};
    const int onset = pulses[0].onset;
    const auto trace = noisy_trace(pulses, kGamma, options.noise_sigma, random);
    const auto peak = peak_at(extractor.extract(trace.data(), trace.size()), onset);
    if (!peak) continue;
    ++tally.found;
    const PeakBound truth = peak_bound(pulses, kGamma, 0, peak->sample - onset, onset,
                                       onset + kGate, options.noise_sigma);
    tally.add(*peak, onset, truth);
    tally.later_maximum += std::abs(truth.time - first_maximum(pulses[0])) > 1.0 ? 1 : 0;
  }
  return tally;
}

TEST(PeakStatistics, ErrorsReachTheBound) {
  struct Case {
    double snr, found, above_bound, later_maximum;
  };
  for (const auto& [snr, found, above_bound, later_maximum] :
       {Case{20.0, 0.99, 1.15, 0.02}, Case{5.0, 0.8, 1.3, 0.08}}) {
    SCOPED_TRACE(snr);
    const Tally tally = single_pulses(snr, 1500, snr > 10 ? 1 : 2);
    EXPECT_GE(tally.found, found * tally.draws);
    EXPECT_LE(tally.time_ratio(), above_bound);
    EXPECT_LE(tally.amplitude_ratio(), above_bound);
    EXPECT_LE(tally.later_maximum, later_maximum * tally.draws);
    // Draws of a chi^2 with 2 degrees of freedom: their mean is normal, of mean 2.
    if (snr > 10) {
      EXPECT_NEAR(tally.nees / tally.found, 2.0, 1.96 * 2.0 / std::sqrt(tally.found));
    }
  }
}

TEST(PeakStatistics, TwoPulsesOneAndAHalfPeriodsApart) {
  constexpr double kSigma = 1.0 / 20.0;
  constexpr int kApart = 15;
  std::mt19937 random(4);
  std::uniform_int_distribution<int> onsets(40, 120);
  std::uniform_real_distribution<double> strength(std::log(0.7), std::log(1.4));
  PeakOptions options;
  options.noise_sigma = kSigma;
  PeakExtractor extractor(options);
  Tally both;
  for (; both.draws < 500; ++both.draws) {
    const int onset = onsets(random);
    const std::vector<TruePulse> pulses = {
        random_pulse(random, onset),
        random_pulse(random, onset + kApart, std::exp(strength(random)))};
    const auto trace = noisy_trace(pulses, 0.0, kSigma, random);
    const auto& peaks = extractor.extract(trace.data(), trace.size());
    const auto first = peak_at(peaks, onset), second = peak_at(peaks, onset + kApart);
    if (!first || !second) continue;
    ++both.found;
    for (std::size_t k = 0; k < 2; ++k) {
      const Peak& peak = k == 0 ? *first : *second;
      const double place = peak.sample - pulses[k].onset;
      both.add(peak, pulses[k].onset,
               peak_bound(pulses, 0.0, k, place, onset, onset + kApart + kGate, kSigma));
    }
  }
  EXPECT_GE(both.found, 475);
  EXPECT_LE(both.time_ratio(), 1.3);
}

}  // namespace
}  // namespace gprodom::gpr
