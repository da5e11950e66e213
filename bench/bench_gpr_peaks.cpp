// Cost of the peaks of a trace of 201 samples: with the fit, without, and of the stages.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "gpr/peaks/peaks.h"
#include "gpr/peaks/peaks_envelope.h"
#include "gpr/peaks/peaks_pulses.h"

namespace {

using gprodom::gpr::PeakExtractor;
using gprodom::gpr::PeakOptions;

constexpr std::size_t kSamples = 201;
constexpr std::size_t kTraces = 200;
constexpr double kOmega = 0.628;  // 500 MHz at 0.2 ns

// Traces as a band-passed profile shows them: `pulses` reflections with a rise of about half a
// period and a decay to a tenth in 2 to 3 periods, at random places at least 1.3 periods apart, and
// 2 % noise.
std::vector<std::vector<float>> make_traces(int pulses) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.02);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<std::vector<float>> traces(kTraces, std::vector<float>(kSamples));
  for (auto& trace : traces) {
    for (float& value : trace) value = static_cast<float>(noise(random));
    const double spacing = (kSamples - 30.0) / pulses;
    for (int k = 0; k < pulses; ++k) {
      const double onset = 8.0 + spacing * k + uniform(random) * std::max(spacing - 13.0, 0.0);
      const double height = 0.3 + 0.7 * uniform(random), phase = 6.283 * uniform(random);
      const double alpha = 2.303 / (20.0 + 10.0 * uniform(random));
      for (std::size_t i = 0; i < kSamples; ++i) {
        const double t = static_cast<double>(i) - onset;
        if (t < -6.0) continue;
        const double envelope = t < 0.0 ? std::exp(-0.15 * t * t) : std::exp(-alpha * t);
        trace[i] += static_cast<float>(height * envelope * std::cos(kOmega * t + phase));
      }
    }
  }
  return traces;
}

void run(benchmark::State& state, const PeakOptions& options, int pulses) {
  const auto traces = make_traces(pulses);
  PeakExtractor extractor(options);
  std::size_t at = 0, peaks = 0;
  for (auto _ : state) {
    peaks += extractor.extract(traces[at].data(), kSamples).size();
    at = (at + 1) % kTraces;
  }
  const auto traces_seen = static_cast<double>(extractor.counts().traces);
  state.counters["pulses"] = static_cast<double>(extractor.counts().pulses) / traces_seen;
  state.counters["peaks"] = static_cast<double>(peaks) / traces_seen;
}

void peaks_fit(benchmark::State& state) { run(state, {}, static_cast<int>(state.range(0))); }
BENCHMARK(peaks_fit)->Arg(3)->Arg(5)->Arg(7);

void peaks_fit_apart(benchmark::State& state) {
  PeakOptions options;
  options.max_joint = 1;
  run(state, options, static_cast<int>(state.range(0)));
}
BENCHMARK(peaks_fit_apart)->Arg(5);

void peaks_envelope(benchmark::State& state) {
  PeakOptions options;
  options.fit = false;
  run(state, options, static_cast<int>(state.range(0)));
}
BENCHMARK(peaks_envelope)->Arg(5);

void stage_analytic_signal(benchmark::State& state) {
  const auto traces = make_traces(5);
  gprodom::gpr::AnalyticSignal signal;
  for (auto _ : state) {
    gprodom::gpr::analytic_signal(traces[0].data(), kSamples, signal);
    benchmark::DoNotOptimize(signal.envelope.data());
  }
}
BENCHMARK(stage_analytic_signal);

void stage_find_pulses(benchmark::State& state) {
  const auto traces = make_traces(5);
  gprodom::gpr::AnalyticSignal signal;
  gprodom::gpr::analytic_signal(traces[0].data(), kSamples, signal);
  std::vector<gprodom::gpr::Pulse> pulses;
  for (auto _ : state) {
    gprodom::gpr::find_pulses(signal, 0.05, 1.5, pulses);
    benchmark::DoNotOptimize(pulses.data());
  }
}
BENCHMARK(stage_find_pulses);

}  // namespace
