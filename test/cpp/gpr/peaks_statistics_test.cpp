// Peaks against the Cramer-Rao bound. SNR is beta over the noise's standard deviation.
//
// The phase is random, so a maximum may lie within the noise of the onset. Then the data do not
// show whether it is the first one. So errors are taken to the nearest maximum of the true curve,
// with that maximum's bound, and a separate limit holds for how often it was not the first one.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "gpr/damped_pulses.h"
#include "gpr/peaks/peaks.h"

namespace gprodom::gpr {
namespace {

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

TEST(PeakStatistics, ErrorsReachTheBoundAtSnr20) {
  const Tally tally = single_pulses(20.0, 1500, 1);
  EXPECT_GE(tally.found, 0.99 * tally.draws);
  EXPECT_LE(tally.time_ratio(), 1.15);
  EXPECT_LE(tally.amplitude_ratio(), 1.15);
  EXPECT_LE(tally.later_maximum, 0.02 * tally.draws);
}

TEST(PeakStatistics, ErrorsReachTheBoundAtSnr5) {
  const Tally tally = single_pulses(5.0, 1500, 2);
  EXPECT_GE(tally.found, 0.8 * tally.draws);
  EXPECT_LE(tally.time_ratio(), 1.3);
  EXPECT_LE(tally.amplitude_ratio(), 1.3);
  EXPECT_LE(tally.later_maximum, 0.08 * tally.draws);
}

// 500 draws of a chi^2 with 2 degrees of freedom: a normal of mean 2, sigma 2 / sqrt(500), to the
// third digit.
TEST(PeakStatistics, CovarianceIsThatOfTheErrors) {
  const Tally tally = single_pulses(20.0, 500, 3);
  ASSERT_GE(tally.found, 495);
  const double mean = tally.nees / tally.found, half_band = 1.96 * 2.0 / std::sqrt(tally.found);
  EXPECT_GE(mean, 2.0 - half_band);
  EXPECT_LE(mean, 2.0 + half_band);
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
