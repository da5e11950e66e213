#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "gpr/allocation_count.h"
#include "gpr/front_end_factory.h"
#include "gpr/synthetic_ground.h"
#include "gprodom/error.h"

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

}  // namespace
}  // namespace gprodom::gpr
