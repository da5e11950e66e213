// What the map costs: the fast path beside it, its own job, with 10 m and 10 km remembered, a
// search of all of it without a prior, and questions near a place of it on another day.
//   build/bench/bench_map
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "bench_ground.h"
#include "map/change_follower.h"
#include "map/locator.h"
#include "map/map_task.h"
#include "map/search_window.h"

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

  // Time goes on by a state: its traces, then the state, and what is due by then.
  void drive(MapTask& task) {
    for (const TimeNs end = time_ + kStateInterval; time_ < end; time_ += kTraceInterval) {
      trace_.time = time_;
      trace_.sample_interval_s = 0.2e-9;
      trace_.samples = ground_[static_cast<std::size_t>(std::fmod(metres(), kPattern) / 0.02)];
      task.add(trace_);
    }
    task.add(state(), time_);
    while (task.next_due(time_)) continue;
  }

  double metres() const { return kSpeed * to_seconds(time_); }

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
    robot.drive(task);
    benchmark::DoNotOptimize(task.correct(estimate));
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
  while (robot.metres() < static_cast<double>(state.range(0))) robot.drive(task);
  const WorkTime before = task.work_time();
  for (auto _ : state) robot.drive(task);
  const WorkTime after = task.work_time();
  state.counters["ms_per_job"] =
      1e3 * (after.total_s - before.total_s) /
      static_cast<double>(std::max<std::int64_t>(1, after.jobs - before.jobs));
}
BENCHMARK(job)->ArgName("metres")->Arg(100)->Arg(10000)->Unit(benchmark::kMicrosecond);

constexpr Eigen::Index kRows = 96;      // of a band-limited column, at most
constexpr std::size_t kDriven = 600;    // columns of the newest ground
constexpr std::size_t kStretch = 2500;  // columns of a run of the map

// Band-limited ground of nothing but noise, smoothed along the track.
gpr::StoredRun noise(std::size_t columns, std::mt19937& random) {
  const gpr::Columns ground =
      gpr::noise_ground(static_cast<Eigen::Index>(columns), kRows, 200.0F, random);
  gpr::StoredRun run;
  run.times.resize(columns);
  run.levels = ground.unaryExpr([](float level) {
    return static_cast<std::int8_t>(std::clamp(std::round(level), -127.0F, 127.0F));
  });
  return run;
}

gpr::BandLimit limit() {
  gpr::BandLimit limit;
  limit.samples = kSamples;
  limit.sample_interval = 0.2e-9;
  limit.step = 3;
  limit.low_cut = 80e6;
  limit.long_sigma = 25.0;
  limit.deviation = Eigen::RowVectorXf::Constant(limit.rows(), 100.0F);
  return limit;
}

// A map of these runs of kStretch columns, side by side; the last one may be shorter.
GroundMap map_of(std::vector<gpr::StoredRun> runs) {
  for (gpr::StoredRun& run : runs) run.levels.conservativeResize(Eigen::NoChange, limit().rows());
  gpr::TraceMemoryOptions options;
  options.max_length_m = 2e4;
  GroundMap ground(options);
  ground.memory.restore({limit()}, runs);
  for (std::size_t run = 0; run < runs.size(); ++run) {
    for (std::size_t column = 0; column < runs[run].times.size(); column += 25) {
      const double along = 0.02 * static_cast<double>(column);
      ground.places.push_back(
          {run * kStretch + column, along, {{along, 5.0 * static_cast<double>(run)}, 0.0}, 0});
    }
  }
  return ground;
}

// A search of all ground, as a robot asks that was reset: travel times and turns of the pulse are
// tried. The likely changes and the others take turns. known: the ground is in the map, and the
// place found is looked at once more. The last metres are the newest ground.
void search(benchmark::State& state) {
  std::mt19937 random(1);
  std::vector<gpr::StoredRun> runs;
  for (double metres = 0; metres < static_cast<double>(state.range(0)); metres += 0.02 * kStretch)
    runs.push_back(noise(kStretch, random));
  gpr::StoredRun newest = noise(kDriven, random);
  if (state.range(2) != 0) newest.levels = runs[runs.size() / 2].levels.middleRows(900, kDriven);
  runs.push_back(newest);
  const GroundMap ground = map_of(std::move(runs));
  const std::size_t columns = ground.memory.kept().end;
  Locator locator;
  const auto ask = [&] { return locator.find(ground, columns - kDriven, {}, {}, 10.0); };
  bool found = ask().has_value();  // learns the ground, and asks for the likely changes
  if (state.range(1) == 0) ask();
  for (auto _ : state) {
    found = ask().has_value();
    state.PauseTiming();
    ask();
    state.ResumeTiming();
  }
  state.counters["found"] = found ? 1 : 0;
}
BENCHMARK(search)
    ->ArgNames({"metres", "unlikely", "known"})
    ->Args({10000, 0, 0})
    ->Args({10000, 1, 0})
    ->Args({10000, 0, 1})
    ->Unit(benchmark::kMillisecond);

// A map of 100 m, and 12 m of other ground driven over on another day.
struct AnotherDay {
  AnotherDay() : ground(map_of({noise(kStretch, random), noise(kStretch, random)})) {
    ground.memory.begin_session();
    const gpr::Columns traces = gpr::noise_ground(kDriven, kSamples, 1000.0F, random);
    for (Eigen::Index i = 0; i < traces.rows(); ++i) {
      const std::vector<float> trace(traces.row(i).begin(), traces.row(i).end());
      ground.memory.add(1 + i, trace, limit().sample_interval, 0.02 * static_cast<double>(i));
    }
  }

  std::mt19937 random{1};
  GroundMap ground;
  const gpr::TraceChange change{0.05, 0.4};  // as believed
};

// A question as the mapper asks it every 25 cm near known ground of another day: the change of the
// ground is undone in the query, one direction is known, and a step of the change is tried, as it
// is where a place was found.
void gated_query(benchmark::State& state) {
  AnotherDay day;
  const gpr::TraceMemory& memory = day.ground.memory;
  gpr::RevisitSearch search(*memory.filter(), memory.spacing(),
                            search_options(GraphConfig(), true));
  ChangeFollower follower;
  gpr::SearchWindow window = window_on(
      memory, kStretch / 2, 0.0, 0.01 * static_cast<double>(state.range(0)), search.reach_m());
  window.mirrored = false;
  for (auto _ : state) {
    const auto query = [&](int before, const gpr::TraceChange& change) {
      return memory.newest(search.patch_columns(), before, change)->features;
    };
    benchmark::DoNotOptimize(search.find(query(kBefore, day.change), kQuerySpacing, {window}));
    follower.believe(day.change);
    follower.follow(memory, kStretch / 2, [&](const auto& change) { return query(0, change); });
  }
}
BENCHMARK(gated_query)->ArgName("bound_cm")->Arg(60)->Arg(500)->Unit(benchmark::kMillisecond);

// What is done every metre besides while a place was told and is not proved: of all changes, the
// one that fits best near there is supposed.
void change_near(benchmark::State& state) {
  const AnotherDay day;
  const Locator::Near near{0, {25.0, 0.0}, 0.01 * static_cast<double>(state.range(0))};
  const std::size_t end = 2 * kStretch;
  for (auto _ : state) benchmark::DoNotOptimize(Locator::change_near(day.ground, end, near));
}
BENCHMARK(change_near)->ArgName("within_cm")->Arg(60)->Arg(500)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gprodom

BENCHMARK_MAIN();
