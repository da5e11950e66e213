// What a message costs on its way in and out, a trace in the coherence front end, and a search of
// all that is remembered: one core.
//   build/bench/bench_message
#include <benchmark/benchmark.h>

#include <vector>

#include "bench_ground.h"
#include "gpr/motion/coherence.h"
#include "gpr/revisit/global_search.h"
#include "gprodom/lcm_io.h"
#include "lcmtypes/gprodom/gpr_trace_t.hpp"
#include "lcmtypes/gprodom/imu_t.hpp"
#include "lcmtypes/gprodom/wheel_t.hpp"
#include "lcmtypes/gprodom/wheels_t.hpp"

namespace gprodom {
namespace {

constexpr int kSamples = gpr::SyntheticGround::kSamples;

// From the packet to the measurement, the check of its layout included.
template <class Message>
void decode(benchmark::State& state, const Message& message, const std::string& channel) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  const ChannelConfig channels;
  for (auto _ : state)
    benchmark::DoNotOptimize(decode_input(channels, channel, bytes.data(), bytes.size()));
}

void decode_imu(benchmark::State& state) { decode(state, imu_t{}, ChannelConfig().imu); }
BENCHMARK(decode_imu)->Unit(benchmark::kMicrosecond);

void decode_wheel(benchmark::State& state) { decode(state, wheel_t{}, ChannelConfig().wheel); }
void decode_wheels(benchmark::State& state) { decode(state, wheels_t{}, ChannelConfig().wheels); }
BENCHMARK(decode_wheel)->Unit(benchmark::kMicrosecond);
BENCHMARK(decode_wheels)->Unit(benchmark::kMicrosecond);

void decode_trace(benchmark::State& state) {
  gpr_trace_t trace{};
  trace.num_samples = kSamples;
  trace.samples.resize(kSamples);
  decode(state, trace, ChannelConfig().gpr_trace);
}
BENCHMARK(decode_trace)->Unit(benchmark::kMicrosecond);

// ODOMETRY, ODOMETRY_MAP and POSE of one estimate.
void encode_estimate(benchmark::State& state) {
  Outputs outputs;
  outputs.odometry.resize(1);
  outputs.odometry_in_map.resize(1);
  const ChannelConfig channels;
  for (auto _ : state) benchmark::DoNotOptimize(make_messages(channels, outputs));
}
BENCHMARK(encode_estimate)->Unit(benchmark::kMicrosecond);

void coherence_trace(benchmark::State& state) {
  std::vector<GprTrace> traces = gpr::synthetic_drive(400, gpr::SyntheticGround(1));
  gpr::CoherenceFrontEnd front_end{GprConfig()};
  TimeNs time = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    GprTrace& trace = traces[i++ % traces.size()];
    trace.time = time += from_seconds(0.05);
    front_end.add_trace(trace);
    benchmark::DoNotOptimize(front_end.tick(time));
  }
}
BENCHMARK(coherence_trace)->Unit(benchmark::kMicrosecond);

// Two metres of traces to features.
void features(benchmark::State& state) {
  const gpr::Columns traces = gpr::noise_ground(1000);
  const gpr::PatchFilter filter(traces, 0.02, 0.2e-9);
  const gpr::Columns patch = traces.topRows(100);
  for (auto _ : state) benchmark::DoNotOptimize(filter.apply(patch));
}
BENCHMARK(features)->Unit(benchmark::kMicrosecond);

// Eight metres looked for in all of the memory.
void anywhere(benchmark::State& state) {
  const gpr::Columns traces = gpr::noise_ground(2000);
  const gpr::PatchFilter filter(traces, 0.02, 0.2e-9);
  const gpr::Columns memory = filter.apply(traces);
  gpr::GlobalSearch search(filter, 0.02);
  for (int metres = 0; metres < state.range(0); metres += 40)
    search.add_run(static_cast<std::size_t>(metres) * 50, memory);
  const gpr::Columns query = memory.middleRows(500, 400);
  for (auto _ : state) benchmark::DoNotOptimize(search.find({{query, {}}}));
  state.counters["bytes_per_metre"] =
      static_cast<double>(search.bytes()) / static_cast<double>(state.range(0));
}
BENCHMARK(anywhere)->ArgName("metres")->Arg(200)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gprodom
