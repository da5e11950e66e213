// Cost per trace of 201 samples of details retention and its steps, and of the standstill test, on
// one core:
//   build/bench/bench_gpr_filter
#include <benchmark/benchmark.h>

#include <vector>

#include "bench_ground.h"
#include "gpr/filter/details_retention.h"
#include "gpr/front_end_factory.h"

namespace gprodom::gpr {
namespace {

constexpr int kSamples = SyntheticGround::kSamples;

// The work of each trace of a drive, again and again.
template <class Work>
void each_trace(benchmark::State& state, Work work) {
  const std::vector<GprTrace> traces = synthetic_drive(400, SyntheticGround(1));
  std::size_t i = 0;
  for (auto _ : state) work(traces[i++ % traces.size()]);
}

void details_retention(benchmark::State& state) {
  DetailsRetention filter{GprFilterConfig()};
  each_trace(state, [&](const GprTrace& trace) {
    benchmark::DoNotOptimize(filter.filter(trace).samples);
  });
}
BENCHMARK(details_retention)->Unit(benchmark::kMicrosecond);

void step_quality(benchmark::State& state) {
  TraceCheck check;
  each_trace(state, [&](const GprTrace& trace) {
    benchmark::DoNotOptimize(check.check(trace.samples.data(), kSamples));
  });
}
BENCHMARK(step_quality)->Unit(benchmark::kMicrosecond);

void step_dewow(benchmark::State& state) {
  std::vector<float> out(kSamples);
  each_trace(state, [&](const GprTrace& trace) {
    dewow(trace.samples.data(), kSamples, 20, out.data());
    benchmark::DoNotOptimize(out.data());
  });
}
BENCHMARK(step_dewow)->Unit(benchmark::kMicrosecond);

void step_time_zero(benchmark::State& state) {
  TimeZeroTracker tracker(13.6, 5.0);
  std::vector<float> out(kSamples);
  each_trace(state, [&](const GprTrace& trace) {
    benchmark::DoNotOptimize(tracker.align(trace.samples.data(), kSamples, out.data()));
  });
}
BENCHMARK(step_time_zero)->Unit(benchmark::kMicrosecond);

void step_wavelet(benchmark::State& state) {
  DetailDenoiser<float> denoiser(make_wavelet(WaveletKind::kSym4), 4, 1.0);
  std::vector<float> out(kSamples);
  each_trace(state, [&](const GprTrace& trace) {
    benchmark::DoNotOptimize(denoiser.apply(trace.samples.data(), kSamples, out.data()));
  });
}
BENCHMARK(step_wavelet)->Unit(benchmark::kMicrosecond);

void step_band_pass(benchmark::State& state) {
  ZeroPhaseFilter<float> filter(design_band_pass(1.5e8, 9e8, 0.2e-9, 1e-8));
  std::vector<float> out(kSamples);
  each_trace(state, [&](const GprTrace& trace) {
    filter.apply(trace.samples.data(), kSamples, out.data());
    benchmark::DoNotOptimize(out.data());
  });
}
BENCHMARK(step_band_pass)->Unit(benchmark::kMicrosecond);

void standstill_test(benchmark::State& state) {
  const auto front_end = make_front_end(GprConfig());
  TimeNs time = 0;
  each_trace(state, [&](GprTrace trace) {
    trace.time = time += from_seconds(0.05);
    front_end->add_trace(trace);
    benchmark::DoNotOptimize(front_end->tick(time));
  });
}
BENCHMARK(standstill_test)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gprodom::gpr
