// Cost per trace of 201 samples of details retention and its steps, and of the standstill test, on
// one core:
//   build/bench/bench_gpr_filter
#include <benchmark/benchmark.h>

#include <vector>

#include "gpr/filter/details_retention.h"
#include "gpr/front_end_factory.h"
#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr int kSamples = SyntheticGround::kSamples;

std::vector<GprTrace> drive() {
  const SyntheticGround ground(1);
  SyntheticRadar radar(2, 60.0);
  std::vector<GprTrace> traces;
  for (int i = 0; i < 400; ++i) traces.push_back(radar.measure(ground, 1.0 + 0.02 * i, 0.05 * i));
  return traces;
}

void details_retention(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  DetailsRetention filter{GprFilterConfig()};
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(filter.filter(traces[i++ % traces.size()]).samples);
  }
}
BENCHMARK(details_retention)->Unit(benchmark::kMicrosecond);

void step_quality(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  TraceCheck check;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(check.check(traces[i++ % traces.size()].samples.data(), kSamples));
  }
}
BENCHMARK(step_quality)->Unit(benchmark::kMicrosecond);

void step_dewow(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  std::vector<float> out(kSamples);
  for (auto _ : state) {
    dewow(traces[0].samples.data(), kSamples, 20, out.data());
    benchmark::DoNotOptimize(out.data());
  }
}
BENCHMARK(step_dewow)->Unit(benchmark::kMicrosecond);

void step_time_zero(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  TimeZeroTracker tracker(13.6, 5.0);
  std::vector<float> out(kSamples);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        tracker.align(traces[i++ % traces.size()].samples.data(), kSamples, out.data()));
  }
}
BENCHMARK(step_time_zero)->Unit(benchmark::kMicrosecond);

void step_wavelet(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  DetailDenoiser<float> denoiser(make_wavelet(WaveletKind::kSym4), 4, 1.0);
  std::vector<float> out(kSamples);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        denoiser.apply(traces[i++ % traces.size()].samples.data(), kSamples, out.data()));
  }
}
BENCHMARK(step_wavelet)->Unit(benchmark::kMicrosecond);

void step_band_pass(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  ZeroPhaseFilter<float> filter(design_band_pass(1.5e8, 9e8, 0.2e-9, 1e-8));
  std::vector<float> out(kSamples);
  for (auto _ : state) {
    filter.apply(traces[0].samples.data(), kSamples, out.data());
    benchmark::DoNotOptimize(out.data());
  }
}
BENCHMARK(step_band_pass)->Unit(benchmark::kMicrosecond);

void standstill_test(benchmark::State& state) {
  const std::vector<GprTrace> traces = drive();
  const auto front_end = make_front_end(GprConfig());
  TimeNs time = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    GprTrace trace = traces[i++ % traces.size()];
    trace.time = time += from_seconds(0.05);
    front_end->add_trace(trace);
    benchmark::DoNotOptimize(front_end->tick(time));
  }
}
BENCHMARK(standstill_test)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gprodom::gpr
