// Cost of the feature matrix, the shift search and the energy curve, and of the whole chain per
// trace, on one core:
//   build/bench/bench_gpr_sfm --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "bench_ground.h"
#include "gpr/filter/details_retention.h"
#include "gpr/front_end_factory.h"
#include "gpr/peaks/peaks.h"
#include "gpr/sequential/alignment.h"
#include "gpr/sequential/dec.h"
#include "gpr/sequential/sfm.h"

namespace gprodom::gpr {
namespace {

constexpr double kTracePeriod = 0.05;  // s

// The front end's whole work per trace of 201 samples, filter, peaks,
// a feature matrix and a match every tenth trace. Over ground with a reflector every 10 cm, at 0.4
// m/s; `peaks` tells how many a trace has.
void per_trace(benchmark::State& state, FrontEndKind method, bool fit) {
  GprConfig config;
  config.front_end = method;
  config.peaks.fit = fit;
  config.sequential.publish_sfm = true;
  std::vector<GprTrace> traces = synthetic_drive(1000, SyntheticGround(1, 25.0));
  PeakOptions options;
  options.fit = fit;
  options.max_joint = 1;  // as the front end
  DetailsRetention filter(config.filter);
  PeakExtractor extractor(options);
  for (const GprTrace& trace : traces) {
    if (const float* filtered = filter.filter(trace).samples) {
      extractor.extract(filtered, trace.samples.size());
    }
  }
  const auto front_end = make_front_end(config);
  std::size_t i = 0;
  for (auto _ : state) {
    GprTrace& trace = traces[i % traces.size()];
    trace.time = from_seconds(kTracePeriod * static_cast<double>(i++));
    front_end->add_trace(trace);
    if (i % 10 == 0) benchmark::DoNotOptimize(front_end->tick(trace.time));
  }
  if (method == FrontEndKind::kSfm) {
    state.counters["peaks"] = static_cast<double>(extractor.counts().accepted) /
                              static_cast<double>(extractor.counts().traces);
  }
}
BENCHMARK_CAPTURE(per_trace, sfm_fit, FrontEndKind::kSfm, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(per_trace, sfm_no_fit, FrontEndKind::kSfm, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(per_trace, bscan, FrontEndKind::kBscan, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(per_trace, dec, FrontEndKind::kDec, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(per_trace, salient, FrontEndKind::kSalient, false)->Unit(benchmark::kMicrosecond);

LevelMatrix random_levels(int rows, int columns) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> level(-20, kMaxFeatureLevel);
  return LevelMatrix::NullaryExpr(
      rows, columns, [&] { return static_cast<std::int8_t>(std::max(0, level(random))); });
}

// Two 50 x 50 matrices over all shifts.
void match_sfm(benchmark::State& state) {
  const LevelMatrix ground = random_levels(50, 60);
  const LevelMatrix a = ground.leftCols(50), b = ground.rightCols(50);
  // 0.3: the default w_min; 0: every shift there is.
  AlignmentOptions options;
  options.min_overlap = static_cast<double>(state.range(0)) / 100.0;
  Aligner aligner(options);
  for (auto _ : state) benchmark::DoNotOptimize(aligner.align(a, b));
}
BENCHMARK(match_sfm)
    ->ArgName("min_overlap_percent")
    ->Arg(30)
    ->Arg(0)
    ->Unit(benchmark::kMicrosecond);

void match_bscan(benchmark::State& state) {
  const Eigen::MatrixXf ground = Eigen::MatrixXf::Random(201, 110);
  const Eigen::MatrixXf a = ground.leftCols(100), b = ground.rightCols(100);
  Aligner aligner;
  for (auto _ : state) benchmark::DoNotOptimize(aligner.align(a, b));
}
BENCHMARK(match_bscan)->Unit(benchmark::kMicrosecond);

void build(benchmark::State& state) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<FeaturePoint> points(1000);  // 100 traces with 10 peaks each
  for (FeaturePoint& p : points) p = {unit(random), unit(random), unit(random)};
  LevelMatrix levels;
  for (auto _ : state) {
    build_sfm(points.data(), points.size(), {50, 50, 1.0, 1.0, 1.0}, levels);
    benchmark::DoNotOptimize(levels.data());
  }
}
BENCHMARK(build)->Unit(benchmark::kMicrosecond);

void dec_points_per_trace(benchmark::State& state) {
  const Eigen::VectorXf trace = Eigen::VectorXf::Random(201);
  Eigen::VectorXf energy(201);
  for (auto _ : state) {
    trace_energy(trace.data(), 201, 5, energy.data());
    benchmark::DoNotOptimize(
        energy_points(energy.data(), 201, 10, background_threshold(energy.data(), 201)));
  }
}
BENCHMARK(dec_points_per_trace)->Unit(benchmark::kMicrosecond);

void dec_refine_and_match(benchmark::State& state) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<EnergyPoints> columns(100);
  for (EnergyPoints& column : columns) {
    column.count = kMaxEnergyPoints;
    for (EnergyPoint& point : column.point) point = {200.0 * unit(random), unit(random)};
  }
  CurveRefiner refiner;
  CurveAligner aligner;
  Eigen::VectorXd curve;
  for (auto _ : state) {
    refiner.refine(columns, curve);
    benchmark::DoNotOptimize(aligner.align(curve, curve));
  }
}
BENCHMARK(dec_refine_and_match)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gprodom::gpr
