#include "gpr/peaks/peaks.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include "gpr/allocation_count.h"
#include "gpr/damped_pulses.h"
#include "gpr/peaks/peaks_covariance.h"
#include "gpr/peaks/peaks_envelope.h"
#include "gpr/peaks/peaks_varpro.h"

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
  constexpr double kStep = 2e-3;
  PeakCovariance numeric = PeakCovariance::Zero();
  for (int row = 0; row < exact.size; ++row) {
    GroupSamples up = exact, down = exact;
    up.value[at(row)] += kStep;
    down.value[at(row)] -= kStep;
    const Eigen::Matrix<double, 7, 1> slope =
        (vector(estimate(up)) - vector(estimate(down))) / (2.0 * kStep);
    numeric += slope * slope.transpose();
  }
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

}  // namespace
}  // namespace gprodom::gpr
