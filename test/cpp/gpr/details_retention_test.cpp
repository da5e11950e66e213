#include "gpr/filter/details_retention.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gpr/allocation_count.h"
#include "gpr/synthetic_ground.h"
#include "gprodom/error.h"

namespace gprodom::gpr {
namespace {

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
