#include "gpr/sequential/dec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gprodom::gpr {
namespace {

constexpr int kSamples = 201;

// A trace with a wavelet of eight samples' period about `row`, and noise.
std::vector<float> trace_with_reflection(double row, double amplitude, std::mt19937& random) {
  std::normal_distribution<float> noise(0.0F, 0.03F);
  std::vector<float> trace(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double t = i - row;
    trace[i] = noise(random) +
               static_cast<float>(amplitude * std::exp(-t * t / 50.0) * std::cos(0.785 * t));
  }
  return trace;
}

EnergyPoints points_of(const std::vector<float>& trace) {
  std::vector<float> energy(trace.size());
  trace_energy(trace.data(), trace.size(), 4, energy.data());
  return energy_points(energy.data(), energy.size(), 10,
                       background_threshold(energy.data(), energy.size()));
}

double layer_row(double metres) {
  return 80 + 12 * std::sin(metres / 7.0) + 6 * std::sin(metres / 2.3);
}

TEST(Dec, BackgroundIsSegmentedAndTheReflectionFound) {
  std::mt19937 random(1);
  const EnergyPoints points = points_of(trace_with_reflection(63.4, 1.0, random));
  ASSERT_GE(points.count, 1);
  EXPECT_NEAR(points.point[0].row, 63.4, 0.7);
  for (int i = 1; i < points.count; ++i) {
    EXPECT_NEAR(points.point[i].row, 63.4, 16) << "a point in the noise";
  }
  EXPECT_EQ(points_of(std::vector<float>(kSamples, 0.0F)).count, 0);
}

TEST(Dec, RefinementFollowsTheLayerThroughGapsAndStrongerClutter) {
  std::mt19937 random(2);
  std::vector<EnergyPoints> columns;
  for (int c = 0; c < 100; ++c) {
    std::vector<float> trace = trace_with_reflection(layer_row(c * 0.2), 1.0, random);
    if (c % 9 == 4) {
      const std::vector<float> clutter = trace_with_reflection(170, 1.5, random);
      for (int i = 0; i < kSamples; ++i) trace[i] += clutter[i];
    }
    columns.push_back(c % 11 == 3 ? EnergyPoints() : points_of(trace));
  }
  Eigen::VectorXd curve;
  ASSERT_TRUE(CurveRefiner().refine(columns, curve));
  for (int c = 0; c < 100; ++c) EXPECT_NEAR(curve[c], layer_row(c * 0.2), 2.5) << c;

  EXPECT_FALSE(CurveRefiner().refine(std::vector<EnergyPoints>(20), curve));
  EXPECT_TRUE(curve.isZero(0.0));
}

TEST(Dec, CurvesAlignWhereTheyWereMoved) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.5);
  for (const double moved : {0.0, 4.0, 12.4}) {
    Eigen::VectorXd a(100), b(100);
    for (int c = 0; c < 100; ++c) {
      a[c] = layer_row(c * 0.2) + noise(random);
      b[c] = layer_row((c + moved) * 0.2) + noise(random);
    }
    const Alignment alignment = CurveAligner().align(a, b);
    EXPECT_TRUE(alignment.valid);
    EXPECT_NEAR(alignment.subcolumn, -moved, 0.5);
  }
  EXPECT_FALSE(CurveAligner().align(Eigen::VectorXd::Ones(50), Eigen::VectorXd::Ones(50)).valid);
}

}  // namespace
}  // namespace gprodom::gpr
