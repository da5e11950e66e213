// The steps of details retention, each by itself.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <stdexcept>

#include "gpr/allocation_count.h"
#include "gpr/filter/background.h"
#include "gpr/filter/band_pass.h"
#include "gpr/filter/details_retention.h"
#include "gpr/filter/time_zero.h"
#include "gpr/filter/trace_quality.h"
#include "gpr/filter/wavelet.h"
#include "gpr/synthetic_ground.h"
#include "gprodom/error.h"
#include "support/noise.h"

namespace gprodom::gpr {
namespace {

constexpr double kInterval = 0.2e-9;

std::vector<double> random_trace(int n, unsigned seed) {
  Noise normal(seed);
  std::vector<double> x(n);
  for (double& v : x) v = normal();
  return x;
}

std::vector<float> single(const std::vector<double>& x) { return {x.begin(), x.end()}; }

double gain_at(const std::vector<double>& taps, double frequency) {
  std::complex<double> sum = 0.0;
  for (std::size_t k = 0; k < taps.size(); ++k) {
    sum += taps[k] * std::polar(1.0, -2.0 * M_PI * frequency * kInterval * static_cast<double>(k));
  }
  return std::abs(sum);
}

TEST(BandPass, PassesTheBandAndStopsTheRest) {
  const std::vector<double> taps = design_band_pass(200e6, 850e6, kInterval, 20e-9);
  EXPECT_EQ(taps.size(), 101u);
  EXPECT_NEAR(gain_at(taps, 525e6), 1.0, 1e-12);
  for (const double pass : {300e6, 400e6, 700e6, 750e6}) EXPECT_GT(gain_at(taps, pass), 0.85);
  for (const double edge : {200e6, 850e6}) EXPECT_NEAR(gain_at(taps, edge), 0.5, 0.05);
  for (const double stop : {0.0, 50e6, 1100e6, 1600e6, 2400e6}) EXPECT_LT(gain_at(taps, stop), 0.1);
}

// The definition: the taps, then the taps reversed, on the trace continued by its end values.
TEST(BandPass, IsTheFilterRunBothWays) {
  const std::vector<double> taps = design_band_pass(200e6, 850e6, kInterval, 5e-9);
  const int n = 83, reach = static_cast<int>(taps.size()) - 1;
  const std::vector<double> x = random_trace(n, 1);
  std::vector<double> expected(n, 0.0), y(n);
  for (int i = 0; i < n; ++i) {
    for (int a = 0; a <= reach; ++a) {
      for (int b = 0; b <= reach; ++b) {
        expected[i] += taps[a] * taps[b] * x[std::clamp(i + a - b, 0, n - 1)];
      }
    }
  }
  ZeroPhaseFilter<double>(taps).apply(x.data(), n, y.data());
  for (int i = 0; i < n; ++i) EXPECT_NEAR(y[i], expected[i], 1e-12) << i;

  std::vector<float> z = single(x);
  ZeroPhaseFilter<float>(taps).apply(z.data(), n, z.data());
  for (int i = 0; i < n; ++i) EXPECT_NEAR(z[i], expected[i], 1e-5) << i;
}

TEST(BandPass, RefusesABandThatCannotBe) {
  EXPECT_THROW(design_band_pass(0.0, 1e9, kInterval, 1e-8), std::invalid_argument);
  EXPECT_THROW(design_band_pass(9e8, 1e8, kInterval, 1e-8), std::invalid_argument);
  EXPECT_THROW(design_band_pass(2.6e9, 3e9, kInterval, 1e-8), std::invalid_argument);
  EXPECT_THROW(design_band_pass(1e8, 9e8, kInterval, 1e-10), std::invalid_argument);
}

TEST(Dewow, SubtractsTheMeanAround) {
  const int n = 50, half = 7;
  const std::vector<double> x = random_trace(n, 2);
  std::vector<double> y(n);
  dewow(x.data(), n, half, y.data());
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    int count = 0;
    for (int k = std::max(0, i - half); k <= std::min(n - 1, i + half); ++k, ++count) sum += x[k];
    EXPECT_NEAR(y[i], x[i] - sum / count, 1e-12) << i;
  }
}

TEST(Gain, GrowsAndThenStaysFlat) {
  const std::vector<double> gain = gain_curve(201, 0.03, 0.7, 80);
  EXPECT_EQ(gain[0], 1.0);
  EXPECT_NEAR(gain[40], std::pow(40.0, 0.7) * std::exp(1.2), 1e-9);
  EXPECT_EQ(gain[200], gain[80]);
  EXPECT_EQ(gain_curve(5, 0.0, 0.0, 80), std::vector<double>(5, 1.0));
}

TEST(Background, IsTheMeanOfTheWindow) {
  const int n = 9, memory = 4;
  RunningBackground background(RunningBackground::Mode::kWindow, memory);
  std::vector<std::vector<double>> traces;
  for (unsigned i = 0; i < 11; ++i) {
    traces.push_back(random_trace(n, i));
    std::vector<float> x = single(traces.back());
    background.remove(x.data(), n);
    const std::size_t first = traces.size() > memory ? traces.size() - memory : 0;
    for (int k = 0; k < n; ++k) {
      double mean = 0.0;
      for (std::size_t j = first; j < traces.size(); ++j) {
        mean += traces[j][k] / static_cast<double>(traces.size() - first);
      }
      EXPECT_NEAR(x[k], traces.back()[k] - mean, 1e-5);
    }
  }
}

// 200 traces at one place, hardly counted, do not make that place the background.
TEST(Background, GroundBelowAStandingRobotDoesNotBecomeBackground) {
  RunningBackground background(RunningBackground::Mode::kRunning, 400);
  std::vector<float> x(1);
  for (int i = 0; i < 200; ++i) {
    x[0] = 10.0f;
    background.remove(x.data(), 1, 0.02f);
  }
  for (int i = 0; i < 36; ++i) {
    x[0] = 0.0f;
    background.remove(x.data(), 1);
  }
  EXPECT_NEAR(background.mean()[0], 1.0, 1e-4);  // 200 * 0.02 of 40 traces
}

TEST(Background, OfASequence) {
  Eigen::MatrixXf bscan(2, 3);
  bscan << 1, 3, 8, 2, 6, -2;
  remove_mean_trace(bscan);
  EXPECT_EQ(bscan, (Eigen::MatrixXf(2, 3) << -3, -1, 4, 0, 4, -4).finished());
}

TEST(TimeZero, DelayOfABandLimitedTrace) {
  const SyntheticGround ground(1);
  for (const double delay : {-3.3, -0.5, 0.25, 1.0}) {
    const std::vector<float> x = single(ground.trace(5.0));
    const std::vector<double> expected = ground.trace(5.0, delay);
    std::vector<float> y(x.size());
    delay_trace(x.data(), static_cast<int>(x.size()), delay, y.data());
    for (std::size_t i = 8; i + 8 < x.size(); ++i) EXPECT_NEAR(y[i], expected[i], 40.0) << i;
  }
}

// Delays of up to three samples over moving ground, found to a tenth of the noise's share.
TEST(TimeZero, IsTrackedOverMovingGround) {
  const SyntheticGround ground(1);
  Noise normal(3);
  TimeZeroTracker tracker(10.0, 5.0);
  double sum = 0.0, squares = 0.0;
  const int count = 300;
  for (int i = 0; i < count; ++i) {
    const double delay = i == 0 ? 0.0 : 3.0 * std::sin(0.05 * i) + 0.2 * normal();
    std::vector<float> x = single(ground.trace(1.0 + 0.02 * i, delay)), y(x.size());
    for (float& v : x) v += static_cast<float>(60.0 * normal());
    const double error = tracker.align(x.data(), static_cast<int>(x.size()), y.data()) - delay;
    sum += error;
    squares += error * error;
  }
  const double mean = sum / count;
  EXPECT_LT(std::sqrt(squares / count - mean * mean), 0.03);
  EXPECT_LT(std::abs(mean), 0.1);  // the first trace's own noise and ground
}

class TraceCheckTest : public testing::Test {
 protected:
  TraceQuality check(std::vector<float> x) {
    return check_.check(x.data(), static_cast<int>(x.size()));
  }
  std::vector<float> trace(double position) {
    return radar_.measure(ground_, position, 0.0).samples;
  }
  SyntheticGround ground_{4};
  SyntheticRadar radar_{5, 60.0};
  TraceCheck check_;
};

TEST_F(TraceCheckTest, TakesGroundThatPassesBy) {
  int bad = 0;
  for (int i = 0; i < 400; ++i) {
    // Stands, drives on at 3 cm a trace, stands.
    const double position = 1.0 + 0.03 * std::clamp(i - 50, 0, 300);
    bad += check(trace(position)) != TraceQuality::kGood ? 1 : 0;
  }
  EXPECT_EQ(bad, 0);
}

TEST_F(TraceCheckTest, FindsDeadAndSpikedTraces) {
  EXPECT_EQ(check(single(random_trace(201, 7))), TraceQuality::kDead);  // before any good one
  for (int i = 0; i < 30; ++i) EXPECT_EQ(check(trace(1.0 + 0.03 * i)), TraceQuality::kGood);

  EXPECT_EQ(check(std::vector<float>(201, -1500.0f)), TraceQuality::kDead);
  std::vector<float> faint = trace(1.9);
  for (float& v : faint) v *= 0.01f;
  EXPECT_EQ(check(faint), TraceQuality::kDead);

  std::vector<float> shifted = trace(1.9);
  std::rotate(shifted.begin(), shifted.begin() + 60, shifted.end());
  EXPECT_EQ(check(shifted), TraceQuality::kSpiked);
  std::vector<float> impulse = trace(1.9);
  impulse[120] = 32767.0f;
  EXPECT_EQ(check(impulse), TraceQuality::kSpiked);
  EXPECT_EQ(check(trace(1.9)), TraceQuality::kGood);
}

// For example another antenna height: after two traces the new state is accepted.
TEST_F(TraceCheckTest, AcceptsALastingJump) {
  for (int i = 0; i < 30; ++i) check(trace(1.0 + 0.03 * i));
  int spiked = 0;
  for (int i = 0; i < 10; ++i) {
    std::vector<float> x = trace(1.9 + 0.03 * i);
    std::rotate(x.begin(), x.begin() + 20, x.end());
    spiked += check(x) == TraceQuality::kSpiked ? 1 : 0;
  }
  EXPECT_GT(spiked, 0);
  EXPECT_LE(spiked, 2);
}

TEST(Wavelet, FiltersAreOrthonormalToTheirEvenShifts) {
  for (const char* name : names_like(WaveletKind::kNone)) {
    const WaveletKind kind = *find_choice<WaveletKind>(name);
    if (kind == WaveletKind::kNone) continue;
    const Wavelet wavelet = make_wavelet(kind);
    const int taps = static_cast<int>(wavelet.low.size());
    for (int shift = 0; shift < taps; shift += 2) {
      double low = 0.0, cross = 0.0;
      for (int j = 0; j + shift < taps; ++j) {
        low += wavelet.low[j] * wavelet.low[j + shift];
        cross += wavelet.low[j] * wavelet.high[j + shift];
      }
      EXPECT_NEAR(low, shift == 0 ? 1.0 : 0.0, 1e-11) << name;
      EXPECT_NEAR(cross, 0.0, 1e-11) << name;
    }
  }
  EXPECT_THROW(make_wavelet(WaveletKind::kNone), std::invalid_argument);
}

TEST(Wavelet, InverseRestoresTheTrace) {
  for (const int levels : {1, 3, 4}) {
    StationaryWavelet<double> transform(make_wavelet(WaveletKind::kSym4), levels);
    const int n = transform.padded(201);
    const std::vector<double> x = random_trace(n, 9);
    std::vector<double> details(n * levels), approximation(n), y(n);
    transform.forward(x.data(), n, details.data(), approximation.data());
    transform.inverse(details.data(), approximation.data(), n, y.data());
    for (int i = 0; i < n; ++i) EXPECT_NEAR(y[i], x[i], 1e-10);
    EXPECT_THROW(transform.forward(x.data(), n - 1, details.data(), approximation.data()),
                 std::invalid_argument);
  }
}

TEST(Wavelet, NoiseSigmaIsTheMedian) {
  std::vector<double> scratch(1000);
  for (int n = 1; n < 400; ++n) {
    std::vector<double> x = random_trace(n, static_cast<unsigned>(n));
    if (n % 3 == 0) std::fill_n(x.begin(), n / 2, 0.0);                 // a muted trace
    if (n % 7 == 0) std::fill_n(x.begin(), n, n % 2 == 0 ? 0.0 : 2.0);  // all alike
    std::vector<double> size;
    for (const double value : x) size.push_back(std::abs(value));
    std::sort(size.begin(), size.end());
    const double median = 0.5 * (size[(n - 1) / 2] + size[n / 2]);
    EXPECT_DOUBLE_EQ(noise_sigma(x.data(), n, scratch.data()), median / 0.6745) << n;
  }
}

FilterOptions options_with(Background background) {
  FilterOptions options;
  options.background = background;
  options.gain_rate = 0.03;
  options.gain_power = 0.7;
  return options;
}

// Noise and wow are nearly removed, and the reflectors are as the band-pass alone, on clean
// ground, leaves of them.
TEST(DetailsRetention, KeepsReflectorsAndDropsTheRest) {
  const SyntheticGround ground(8);
  SyntheticRadar radar(9, 10.0);
  DetailsRetention noisy{FilterOptions()};
  FilterOptions linear;
  linear.wavelet = WaveletKind::kNone;
  linear.time_zero_max = 0.0;
  DetailsRetention clean(linear);
  double noise = 0.0, both = 0.0, energy = 0.0, clean_energy = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double position = 1.0 + 0.03 * i;
    const GprTrace trace = radar.measure(ground, position, 0.05 * i);
    const std::vector<double> exact = ground.trace(position);
    const std::vector<float> exact_samples(exact.begin(), exact.end());
    const DetailsRetention::Result a = noisy.filter(trace);
    const DetailsRetention::Result b =
        clean.filter(exact_samples.data(), SyntheticGround::kSamples, trace.sample_interval_s);
    ASSERT_EQ(a.quality, TraceQuality::kGood);
    ASSERT_EQ(b.quality, TraceQuality::kGood);
    if (i < 100) continue;
    noise += a.noise / 200.0;
    for (int k = 35; k < SyntheticGround::kSamples; ++k) {  // below the direct wave
      both += static_cast<double>(a.samples[k]) * b.samples[k];
      energy += static_cast<double>(a.samples[k]) * a.samples[k];
      clean_energy += static_cast<double>(b.samples[k]) * b.samples[k];
    }
  }
  EXPECT_GT(noise, 8.0);
  EXPECT_LT(noise, 15.0);  // the finest details hold some of the reflectors as well
  EXPECT_GT(both / std::sqrt(energy * clean_energy), 0.97);
  EXPECT_NEAR(energy / clean_energy, 1.0, 0.25);
}

TEST(DetailsRetention, FlagsBadTracesAndGoesOn) {
  const SyntheticGround ground(8);
  SyntheticRadar radar(9, 60.0);
  DetailsRetention filter{FilterOptions()};
  for (int i = 0; i < 20; ++i) filter.filter(radar.measure(ground, 1.0 + 0.03 * i, 0.05 * i));
  GprTrace dead = radar.measure(ground, 1.6, 1.0);
  std::fill(dead.samples.begin(), dead.samples.end(), 0.0f);
  const DetailsRetention::Result bad = filter.filter(dead);
  EXPECT_EQ(bad.quality, TraceQuality::kDead);
  EXPECT_EQ(bad.samples, nullptr);
  EXPECT_NE(filter.filter(radar.measure(ground, 1.63, 1.05)).samples, nullptr);
}

TEST(DetailsRetention, AllocatesNothingOnceWarm) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer has the allocator";
  const SyntheticGround ground(8);
  SyntheticRadar radar(9, 60.0);
  std::vector<GprTrace> traces;
  for (int i = 0; i < 40; ++i) traces.push_back(radar.measure(ground, 1.0 + 0.03 * i, 0.05 * i));
  std::fill(traces[30].samples.begin(), traces[30].samples.end(), 0.0f);
  for (const Background background :
       {Background::kRunning, Background::kWindow, Background::kNone}) {
    DetailsRetention filter(options_with(background));
    filter.filter(traces[0]);
    filter.filter(traces[1]);
    const std::size_t before = allocation_count();
    for (const GprTrace& trace : traces) filter.filter(trace);
    EXPECT_EQ(allocation_count(), before) << name_of(background);
  }
}

TEST(DetailsRetention, RefusesSettingsThatContradict) {
  FilterOptions options;
  options.background_memory = 0;
  EXPECT_THROW(DetailsRetention{options}, std::invalid_argument);
  GprFilterConfig config;
  config.band_low = 1e9;
  EXPECT_THROW(DetailsRetention{config}, ConfigError);
}

}  // namespace
}  // namespace gprodom::gpr
