// Cost of revisits on one core: a gated query, and a trace into the memory.
//   build/bench/bench_gpr_revisit
#include <benchmark/benchmark.h>

#include <vector>

#include "bench_ground.h"
#include "gpr/revisit/revisit_search.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom::gpr {
namespace {

constexpr int kSamples = 201, kPatch = 92;
constexpr double kSampleInterval = 0.2e-9;

// The figure: +-0.6 m, both directions, five scales, a patch of 1.84 m.
void gated_query(benchmark::State& state) {
  const Columns traces = noise_ground(1000);
  const PatchFilter filter(traces, 0.02, kSampleInterval);
  const Columns memory = filter.apply(traces), query = memory.middleRows(430, kPatch);
  PatchMatcher matcher(filter, 0.02);
  const double bound = 0.01 * static_cast<double>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(matcher.match(memory, query, -0.5, bound));
}
BENCHMARK(gated_query)
    ->ArgName("bound_cm")
    ->Arg(60)
    ->Arg(330)
    ->Arg(500)
    ->Unit(benchmark::kMillisecond);

// A question as the mapper asks it, one direction known, of a window in which the robot was not
// found so far: the ground may be stretched by a slip of that standard deviation (ln).
void question(benchmark::State& state) {
  const Columns traces = noise_ground(1000);
  const PatchFilter filter(traces, 0.02, kSampleInterval);
  const Columns other = filter.apply(noise_ground(1200)).bottomRows(150);
  SearchWindow window;
  window.features = filter.apply(traces);
  window.expected = 500;
  window.bound_m = 0.01 * static_cast<double>(state.range(0));
  window.stretch_sigma = window.stretch_change = 0.01 * static_cast<double>(state.range(1));
  window.mirrored = false;
  RevisitSearch search(filter, 0.02);
  for (auto _ : state) benchmark::DoNotOptimize(search.find(other, 0.25, {window}));
}
BENCHMARK(question)
    ->ArgNames({"bound_cm", "slip_percent"})
    ->ArgsProduct({{60, 330, 500}, {0, 5, 38}})
    ->Unit(benchmark::kMillisecond);

// A trace every 1.5 cm, with `metres` of ground in memory already.
void add_trace(benchmark::State& state) {
  const Columns traces = noise_ground(2000);
  std::vector<std::vector<float>> list(traces.rows());
  for (Eigen::Index i = 0; i < traces.rows(); ++i) {
    list[i].assign(traces.row(i).data(), traces.row(i).data() + kSamples);
  }
  TraceMemory memory;
  std::size_t i = 0;
  const auto add = [&] {
    memory.add(static_cast<TimeNs>(i) * 50000000, list[i % list.size()], kSampleInterval,
               0.015 * static_cast<double>(i));
    ++i;
  };
  while (0.015 * static_cast<double>(i) < static_cast<double>(state.range(0))) add();
  for (auto _ : state) add();
  state.counters["bytes_per_metre"] =
      static_cast<double>(memory.bytes()) /
      (memory.spacing() * static_cast<double>(memory.kept().size()));
}
BENCHMARK(add_trace)->ArgName("metres")->Arg(10)->Arg(10000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gprodom::gpr

BENCHMARK_MAIN();
