// Cost of the feature matrix, the shift search and the energy curve, on one core:
//   build/bench/bench_gpr_sfm
#include <benchmark/benchmark.h>

#include <random>

#include "gprodom/gpr/alignment.h"
#include "gprodom/gpr/dec.h"
#include "gprodom/gpr/sfm.h"

namespace gprodom::gpr {
namespace {

LevelMatrix random_levels(int rows, int columns) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> level(-20, kMaxFeatureLevel);
  return LevelMatrix::NullaryExpr(
      rows, columns, [&] { return static_cast<std::int8_t>(std::max(0, level(random))); });
}

// The figure: two 50 x 50 matrices over all shifts.
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
