#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <stdexcept>

#include "gpr/allocation_count.h"
#include "gpr/front_end_factory.h"
#include "gpr/sequential/apexes.h"
#include "gpr/sequential/dec.h"
#include "gpr/synthetic_ground.h"
#include "gprodom/error.h"
#include "support/noise.h"

namespace gprodom::gpr {
namespace {

constexpr double kTracePeriod = 0.05;

// 5 columns of 0.04 m per step of 10 traces.
GprConfig config_of(FrontEndKind front_end) {
  GprConfig config;
  config.front_end = front_end;
  config.sequential.publish_sfm = true;
  return config;
}

struct Answers {
  std::vector<TrackDisplacement> displacements;
  std::vector<SubsurfaceFeatureMatrix> sfm;
};

// s; the levels of sfm need the first 20 s, the other methods two windows of 5 s.
double duration(FrontEndKind method, double others) {
  return method == FrontEndKind::kSfm ? others + 16.0 : others;
}

// Drives a front end for `duration` s over a line; `position` is the robot's place (m) at a time
// (s).
Answers drive(const GprConfig& config, double duration,
              const std::function<double(double)>& position,
              const std::function<void(int, GprTrace&)>& spoil = {}) {
  static const SyntheticGround ground(4, 25.0);
  SyntheticRadar radar(5, 30.0);
  const auto front_end = make_front_end(config);
  Answers run;
  for (int i = 0; i * kTracePeriod < duration; ++i) {
    const double time = i * kTracePeriod;
    GprTrace trace = radar.measure(ground, position(time), time);
    if (spoil) spoil(i, trace);
    front_end->add_trace(trace);
    if (i % 2 == 1) {
      for (const Finding& finding : front_end->tick(trace.time))
        run.displacements.push_back(std::get<TrackDisplacement>(finding));
      if (const auto sfm = front_end->sfm()) run.sfm.push_back(*sfm);
    }
  }
  return run;
}

double steady(double time) { return 0.4 * time; }

class SequentialMethods : public testing::TestWithParam<FrontEndKind> {};

TEST_P(SequentialMethods, StepOfTenTracesIsFiveColumns) {
  const Answers run = drive(config_of(GetParam()), duration(GetParam(), 20.0), steady);
  // Few apexes make a matrix: one near the edge of a cell moves the shift by half a column.
  const double tolerance = GetParam() == FrontEndKind::kSalient ? 0.021 : 0.02;
  int valid = 0, close = 0;
  TimeNs end = 0;
  for (const TrackDisplacement& d : run.displacements) {
    EXPECT_EQ(d.source, name_of(GetParam()));
    EXPECT_NEAR(to_seconds(d.to - d.from), 0.5, 1e-9);
    EXPECT_TRUE(end == 0 || d.from == end) << "steps follow one another";
    end = d.to;
    valid += d.valid ? 1 : 0;
    close += d.valid && std::abs(d.distance_m - 0.2) < tolerance ? 1 : 0;
    EXPECT_TRUE(!d.valid || d.sigma_m >= 0.05);
  }
  // Two windows of 5 s take 5.5 s to fill; counting traces needs none.
  EXPECT_GE(valid, 27);
  EXPECT_GE(close, valid - (GetParam() == FrontEndKind::kDec ? 3 : 0));
}

TEST_P(SequentialMethods, StandsForGapsAndBadTraces) {
  const auto spoil = [](int i, GprTrace& trace) {
    if (i % 40 == 7) std::fill(trace.samples.begin(), trace.samples.end(), 0.0F);  // dead
  };
  const Answers run = drive(config_of(GetParam()), duration(GetParam(), 15.0), steady, spoil);
  int close = 0;
  for (const TrackDisplacement& d : run.displacements) {
    close += d.valid && std::abs(d.distance_m - 0.2) < 0.02 ? 1 : 0;
  }
  EXPECT_GE(close, 15);
}

INSTANTIATE_TEST_SUITE_P(All, SequentialMethods,
                         testing::Values(FrontEndKind::kSfm, FrontEndKind::kBscan,
                                         FrontEndKind::kDec, FrontEndKind::kSalient,
                                         FrontEndKind::kTraceCount),
                         [](const auto& info) { return name_of(info.param); });

// What docs/sfm.md explains: windows of one stream share their traces, and the shift counts the new
// ones, at any speed and in either direction.
TEST(Sequential, ShiftCountsTracesWhateverTheRobotDid) {
  const auto there_and_back = [](double t) { return 5.0 + 2.5 * std::sin(0.4 * t); };
  const Answers run = drive(config_of(FrontEndKind::kSfm), 46.0, there_and_back);
  int same = 0, valid = 0, backwards = 0;
  for (const TrackDisplacement& d : run.displacements) {
    if (!d.valid) continue;
    ++valid;
    same += std::abs(d.distance_m - 0.2) < 0.02 ? 1 : 0;
    backwards += there_and_back(to_seconds(d.to)) < there_and_back(to_seconds(d.from)) ? 1 : 0;
  }
  EXPECT_GT(backwards, 15);
  EXPECT_GE(same, valid - 2);
}

TEST(Sequential, FeatureMatricesComeOncePerStepAndOnlyWhenAskedFor) {
  GprConfig config = config_of(FrontEndKind::kSfm);
  const Answers run = drive(config, 31.0, steady);
  ASSERT_GT(run.sfm.size(), 15U);
  for (const SubsurfaceFeatureMatrix& sfm : run.sfm) {
    EXPECT_EQ(sfm.level.rows(), 50);
    EXPECT_EQ(sfm.level.cols(), 50);
    EXPECT_LE(sfm.level.maxCoeff(), 10);
    EXPECT_GT((sfm.level.array() > 0).count(), 50);
    EXPECT_NEAR(sfm.column_spacing_s, 0.1, 1e-9);
  }
  EXPECT_EQ(run.sfm[1].time - run.sfm[0].time, from_seconds(0.5));
  config.sequential.publish_sfm = false;
  EXPECT_TRUE(drive(config, 31.0, steady).sfm.empty());
}

TEST(Sequential, NothingIsValidBeforeTheAmplitudeScaleIsFixed) {
  const Answers run = drive(config_of(FrontEndKind::kSfm), 25.0, steady);
  ASSERT_FALSE(run.displacements.empty());
  for (const TrackDisplacement& d : run.displacements) {
    EXPECT_EQ(d.valid, to_seconds(d.to) > 20.5) << to_seconds(d.to);
  }
}

TEST(Sequential, SettingsThatCannotBeAreRefused) {
  GprConfig config = config_of(FrontEndKind::kSfm);
  config.sequential.columns = config.sequential.window_traces + 1;
  EXPECT_THROW(make_front_end(config), ConfigError);
}

TEST_P(SequentialMethods, NoAllocationPerTraceOnceWarm) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer holds the allocator";
  const SyntheticGround ground(6, 25.0);
  SyntheticRadar radar(7, 30.0);
  std::vector<GprTrace> traces;
  for (int i = 0; i < 700; ++i) {
    traces.push_back(radar.measure(ground, steady(i * kTracePeriod), i * kTracePeriod));
  }
  const auto front_end = make_front_end(config_of(GetParam()));
  std::size_t counted = 0;
  for (int i = 0; i < 700; ++i) {
    const std::size_t before = allocation_count();
    front_end->add_trace(traces[i]);
    if (i >= 550) counted += allocation_count() - before;
    if (i % 2 == 1) front_end->tick(traces[i].time);
  }
  EXPECT_EQ(counted, 0U);
}

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
  Noise noise(3);
  for (const double moved : {0.0, 4.0, 12.4}) {
    Eigen::VectorXd a(100), b(100);
    for (int c = 0; c < 100; ++c) {
      a[c] = layer_row(c * 0.2) + noise(0.5);
      b[c] = layer_row((c + moved) * 0.2) + noise(0.5);
    }
    const Alignment alignment = CurveAligner().align(a, b);
    EXPECT_TRUE(alignment.valid);
    EXPECT_NEAR(alignment.subcolumn, -moved, 0.5);
  }
  EXPECT_FALSE(CurveAligner().align(Eigen::VectorXd::Ones(50), Eigen::VectorXd::Ones(50)).valid);
}

constexpr double kInterval = 2e-10, kZero = 4e-9, kFrequency = 5e8;
constexpr int kColumns = 100;
const ApexOptions kOptions{kInterval, kZero};

double ricker(double t) {
  const double a = std::pow(M_PI * kFrequency * t, 2);
  return (1.0 - 2.0 * a) * std::exp(-a);
}

// Noise of unit variance that is alike in neighbouring columns, as echoes of the ground are.
Eigen::MatrixXf clutter(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Eigen::MatrixXf bscan = Eigen::MatrixXf::NullaryExpr(
      kSamples, kColumns, [&](Eigen::Index, Eigen::Index) { return normal(random); });
  for (int c = 1; c < kColumns; ++c) bscan.col(c) = 0.8F * bscan.col(c - 1) + 0.6F * bscan.col(c);
  return bscan;
}

void add_hyperbola(Eigen::MatrixXf& bscan, double column, double time, double widening,
                   double amplitude) {
  for (int c = 0; c < kColumns; ++c) {
    const double arrival = kZero + std::hypot(time, widening * (c - column));
    for (int r = 0; r < kSamples; ++r)
      bscan(r, c) += static_cast<float>(amplitude * ricker(r * kInterval - arrival));
  }
}

TEST(Apexes, ColumnTimeAndWideningOfAHyperbolaAreFound) {
  for (const double widening : {0.25e-9, 0.4e-9, 0.7e-9}) {
    Eigen::MatrixXf bscan = clutter(3);
    add_hyperbola(bscan, 46.3, 10e-9, widening, 8.0);
    const std::vector<Apex> apexes = find_apexes(bscan, kOptions);
    ASSERT_FALSE(apexes.empty()) << widening;
    EXPECT_NEAR(apexes[0].column, 46.3, 0.5);
    EXPECT_NEAR(apexes[0].time_s, 10e-9, 0.3e-9);
    EXPECT_NEAR(apexes[0].widening_s / widening, 1.0, 0.07);
  }
}

TEST(Apexes, TwoAreToldApartAndTheStrongerComesFirst) {
  Eigen::MatrixXf bscan = clutter(4);
  add_hyperbola(bscan, 30.0, 8e-9, 0.4e-9, 8.0);
  add_hyperbola(bscan, 70.0, 14e-9, 0.4e-9, 16.0);
  const std::vector<Apex> apexes = find_apexes(bscan, kOptions);
  ASSERT_EQ(apexes.size(), 2U);
  EXPECT_NEAR(apexes[0].column, 70.0, 0.5);
  EXPECT_NEAR(apexes[1].column, 30.0, 0.5);
}

// 1 % of B-scans of random ground have one: of 40, more than three in 2 % of all cases at most.
TEST(Apexes, RandomGroundHasHardlyAny) {
  int with = 0;
  for (unsigned seed = 100; seed < 140; ++seed)
    with += find_apexes(clutter(seed), kOptions).empty() ? 0 : 1;
  EXPECT_LE(with, 3);
}

TEST(Apexes, ALayerIsNone) {
  Eigen::MatrixXf bscan = clutter(5);
  add_hyperbola(bscan, 50.0, 10e-9, 0.0, 20.0);
  EXPECT_TRUE(find_apexes(bscan, kOptions).empty());
}

TEST(Apexes, ThresholdIsThatOfItsDistribution) {
  // n independent columns: the median is 1 - 2^(-1/(n-1)).
  const double n = 12.0;
  const double threshold = semblance_threshold(1.0 - std::pow(2.0, -1.0 / (n - 1.0)), 1e-3);
  EXPECT_NEAR(std::pow(1.0 - threshold, n - 1.0), 1e-3, 1e-9);
  EXPECT_EQ(semblance_threshold(0.0, 1e-3), 1.0);
}

TEST(Apexes, EmptyShortAndWrongInputGivesNoneOrIsRefused) {
  EXPECT_TRUE(find_apexes(Eigen::MatrixXf(), kOptions).empty());
  EXPECT_TRUE(find_apexes(Eigen::MatrixXf::Ones(20, 3), kOptions).empty());
  EXPECT_TRUE(find_apexes(Eigen::MatrixXf::Zero(kSamples, kColumns), kOptions).empty());
  EXPECT_THROW(find_apexes(Eigen::MatrixXf::Zero(9, 9), ApexOptions()), std::invalid_argument);
}

}  // namespace
}  // namespace gprodom::gpr
