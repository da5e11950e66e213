// What the map costs: the fast path beside it, and its own job, with 10 m and 10 km remembered.
//   build/bench/bench_map
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "map/map_task.h"

namespace gprodom {
namespace {

constexpr int kSamples = 201;
constexpr double kSpeed = 0.5;                  // m/s
constexpr double kPattern = 40.0;               // m after which the traces repeat
constexpr TimeNs kStateInterval = 200'000'000;  // 5 states a second
constexpr TimeNs kTraceInterval = 50'000'000;   // 20 traces a second

// What the fast path hands to the map while the robot drives straight on. It meets no place twice:
// a question to the memory is in bench_gpr_revisit.
class Robot {
 public:
  Robot() : ground_(static_cast<std::size_t>(kPattern / 0.02)) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    for (auto& column : ground_) {
      column.resize(kSamples);
      for (float& sample : column) sample = 1000.0F * normal(random);
    }
  }

  // Time goes on by a state: its traces, then the state.
  template <class Trace, class State>
  void drive(Trace on_trace, State on_state) {
    for (const TimeNs end = time_ + kStateInterval; time_ < end; time_ += kTraceInterval) {
      trace_.time = time_;
      trace_.sample_interval_s = 0.2e-9;
      trace_.samples = ground_[static_cast<std::size_t>(std::fmod(metres(), kPattern) / 0.02)];
      on_trace(trace_);
    }
    on_state(state());
  }

  double metres() const { return kSpeed * to_seconds(time_); }
  TimeNs time() const { return time_; }

 private:
  StateResult state() const {
    StateResult result;
    const auto at = [&](TimeNs time) {
      NavState x;
      x.time = time;
      x.p_odom.x() = kSpeed * to_seconds(time);
      return x;
    };
    result.state = at(time_);
    result.covariance = 1e-6 * (1.0 + to_seconds(time_) * 1e-3) * StateMatrix::Identity();
    if (time_ > 5 * kStateInterval) result.settled = at(time_ - 5 * kStateInterval);
    return result;
  }

  std::vector<std::vector<float>> ground_;
  GprTrace trace_;
  TimeNs time_ = kStateInterval;
};

// The calls of the fast path alone, the mapper at work on its own thread: a fifth of a second.
void fast_path(benchmark::State& state) {
  Robot robot;
  MapTask task(Config(), Execution::kThreaded);
  OdometryEstimate estimate;
  const auto go = [&] {
    robot.drive([&](const GprTrace& trace) { task.add(trace); },
                [&](const StateResult& result) {
                  task.add(result, result.state.time);
                  while (task.next_due(robot.time())) continue;
                  benchmark::DoNotOptimize(task.correct(estimate));
                });
  };
  while (robot.metres() < static_cast<double>(state.range(0))) {
    go();
    if (std::fmod(robot.metres(), 10.0) < 0.1) task.drain();
  }
  task.drain();
  for (auto _ : state) {
    go();
    state.PauseTiming();
    task.drain();
    state.ResumeTiming();
  }
}
BENCHMARK(fast_path)->ArgName("metres")->Arg(10)->Arg(10000)->Unit(benchmark::kMicrosecond);

// The job itself, half a second of driving: traces into the memory, two questions to it.
void job(benchmark::State& state) {
  Robot robot;
  MapTask task(Config(), Execution::kInline);
  const auto go = [&] {
    robot.drive([&](const GprTrace& trace) { task.add(trace); },
                [&](const StateResult& result) {
                  task.add(result, result.state.time);
                  while (task.next_due(robot.time())) continue;
                });
  };
  while (robot.metres() < static_cast<double>(state.range(0))) go();
  const WorkTime before = task.work_time();
  for (auto _ : state) go();
  const WorkTime after = task.work_time();
  state.counters["ms_per_job"] =
      1e3 * (after.total_s - before.total_s) /
      static_cast<double>(std::max<std::int64_t>(1, after.jobs - before.jobs));
}
BENCHMARK(job)->ArgName("metres")->Arg(100)->Arg(10000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gprodom

BENCHMARK_MAIN();
