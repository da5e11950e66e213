#include "gpr/revisit/trace_memory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "gpr/revisit/revisit.h"
#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr int kPatch = 92;

// Drives from one position to another at 0.3 m/s and 20 traces/s.
class Drive {
 public:
  explicit Drive(TraceMemoryOptions options = {}) : ground(3, 40.0), memory(options) {}

  void to(double target) {
    const double step = target > position ? 0.015 : -0.015;
    while (std::abs(target - position) > 0.01) {
      position += step;
      time += 0.05;
      GprTrace trace = radar.measure(ground, position, time);
      if (glitch_every > 0 && ++traces % glitch_every == 0) {
        for (float& sample : trace.samples) sample *= -3.0F;
      }
      memory.add(trace.time, trace.samples, trace.sample_interval_s, position);
    }
  }

  SyntheticGround ground;
  SyntheticRadar radar{1, 60.0};
  TraceMemory memory;
  double position = 1.0, time = 0.0;
  int glitch_every = 0, traces = 0;  // each so many traces one is a glitch of the receiver
};

TEST(TraceMemory, ColumnsLieWhereTheAntennaWas) {
  Drive drive;
  drive.to(9.0);
  drive.to(2.0);
  const MemoryRange kept = drive.memory.kept();
  ASSERT_GT(kept.size(), 500U);
  const MemoryRange out = drive.memory.run_of(kept.first);
  const MemoryRange back = drive.memory.run_of(out.end);
  EXPECT_EQ(back.end, kept.end);
  for (const std::size_t i : {out.first, out.first + 77, out.end - 1}) {
    const MemoryColumn column = drive.memory.column(i);
    EXPECT_EQ(column.direction, 1);
    EXPECT_NEAR(column.distance_m, 1.015 + 0.02 * static_cast<double>(i), 1e-9);
    EXPECT_NEAR(to_seconds(column.time), (column.distance_m - 1.0) / 0.3, 1e-3);
  }
  EXPECT_NEAR(drive.memory.column(out.end - 1).distance_m, 9.0, 0.025);
  EXPECT_EQ(drive.memory.column(back.first).direction, -1);
  EXPECT_NEAR(drive.memory.column(back.first).distance_m, 8.95, 0.03);
  EXPECT_LT(drive.memory.column(back.end - 1).distance_m,
            drive.memory.column(back.first).distance_m - 3.0);
  // Forgotten or not there yet.
  EXPECT_THROW(drive.memory.column(kept.end), std::out_of_range);
  EXPECT_THROW(drive.memory.patch({kept.first, kept.end + 1}), std::out_of_range);
}

TEST(TraceMemory, TheWayBackIsFoundMirroredOnTheWayOut) {
  Drive drive;
  drive.to(16.0);
  double squares = 0.0;
  int n = 0;
  for (double position = 13.0; position > 4.0; position -= 0.7) {
    drive.to(position);
    const auto newest = drive.memory.newest(kPatch);
    ASSERT_TRUE(newest);
    const MemoryRange run = drive.memory.run_of(drive.memory.kept().first);
    const Columns out = drive.memory.patch(run);
    const double centre = 0.5 * (drive.memory.column(run.first).distance_m +
                                 drive.memory.column(run.end - 1).distance_m);
    const double truth = newest->centre.distance_m - centre;
    PatchMatcher matcher(*drive.memory.filter(), drive.memory.spacing());
    const RevisitMatch match = matcher.match(out, newest->features, truth - 0.3, 0.6);
    ASSERT_TRUE(match.accepted) << position << " score " << match.score;
    EXPECT_TRUE(match.mirrored);
    EXPECT_NEAR(match.offset_m, truth, 0.01) << position;
    squares += (match.offset_m - truth) * (match.offset_m - truth);
    ++n;
  }
  EXPECT_LT(std::sqrt(squares / n), 0.004);
}

// A glitch decides no correlation: the ground is as without it.
TEST(TraceMemory, GlitchesOfTheReceiverAreLeftOut) {
  Drive clean, glitched;
  clean.to(6.0);
  glitched.to(6.0);
  glitched.glitch_every = 30;  // each 45 cm
  clean.to(12.0);
  glitched.to(12.0);
  const Columns right = clean.memory.newest(kPatch)->features;
  const Columns found = glitched.memory.newest(kPatch)->features;
  EXPECT_LT((found - right).rowwise().norm().maxCoeff(), 0.5F * right.rowwise().norm().mean());
}

// What is stored lags behind the antenna; the newest ground does not, and is the same as will be
// stored. A part of the track that is known is a gap.
TEST(TraceMemory, TheNewestGroundReachesTheAntenna) {
  Drive drive;
  drive.to(9.0);
  const std::size_t all = drive.memory.newest_columns(0), stored = drive.memory.kept().end;
  EXPECT_NEAR(drive.memory.newest_column().distance_m, 9.0, 0.04);  // a trace waits for the next
  EXPECT_NEAR(static_cast<double>(all) * 0.02, 8.0, 0.05);
  ASSERT_GT(all, stored + 25);
  EXPECT_EQ(drive.memory.newest_columns(100), all - 100);
  const Columns newest = drive.memory.newest_ground(all);
  drive.to(16.0);
  const Columns later = drive.memory.patch({0, all});
  const auto settled = static_cast<Eigen::Index>(all) - 75;  // before the reach of the band-pass
  EXPECT_LT((newest - later).topRows(settled).cwiseAbs().maxCoeff(), 0.05F);
  EXPECT_GT(later.cwiseAbs().maxCoeff(), 1.0F);
  drive.memory.mark_known(15.0, 16.5);
  drive.to(19.0);
  EXPECT_LT(drive.memory.newest_columns(0), static_cast<std::size_t>(3.0 / 0.02));
  drive.memory.end_run();
  EXPECT_GT(drive.memory.newest_columns(0), static_cast<std::size_t>(10.0 / 0.02));
  EXPECT_EQ(drive.memory.newest_columns(drive.memory.kept().end), 0U);
}

TEST(TraceMemory, IsBoundedAndSmall) {
  TraceMemoryOptions options;
  options.max_length_m = 10.0;
  Drive drive(options);
  drive.to(30.0);
  const MemoryRange kept = drive.memory.kept();
  EXPECT_GT(kept.first, 0U);
  EXPECT_LE(static_cast<double>(kept.size()) * options.spacing_m, options.max_length_m);
  EXPECT_GE(static_cast<double>(kept.size()) * options.spacing_m, options.max_length_m - 1.0);
  EXPECT_LE(static_cast<double>(drive.memory.bytes()), 10.5e3 * options.max_length_m);
  // Numbers and places stay when the oldest ground goes.
  EXPECT_NEAR(drive.memory.column(kept.first).distance_m,
              1.015 + 0.02 * static_cast<double>(kept.first), 1e-6);
}

TEST(TraceMemory, KnownGroundIsNotStoredTwice) {
  Drive drive;
  drive.to(12.0);
  drive.memory.end_run();
  // Back again. From 9 m on the ground is known, except for a stretch of 1 m and one of 6 m.
  const std::size_t before = drive.memory.kept().end;
  for (double position = 11.0; position > -14.0; position -= 0.25) {
    drive.to(position);
    const bool seen = position < 9.0 && !(position > 6.0 && position < 7.0) &&
                      !(position > -4.0 && position < 2.0);
    if (seen) drive.memory.mark_known(position + 1.8, position);
  }
  drive.memory.end_run();
  const MemoryRange first = drive.memory.run_of(before);
  const MemoryRange kept = drive.memory.kept();
  EXPECT_EQ(first.first, before);
  // On the way back, the ground before the first known stretch and the one metre are too short to
  // be stored. The six metres are stored, less the reach of the patches on both sides.
  EXPECT_GT(kept.end - first.first, static_cast<std::size_t>(3.0 / 0.02));
  EXPECT_LT(kept.end - first.first, static_cast<std::size_t>(7.0 / 0.02));
  const MemoryColumn begin = drive.memory.column(first.end - 1);
  EXPECT_EQ(begin.direction, -1);
  EXPECT_GT(begin.distance_m, -4.5);
  EXPECT_EQ(drive.memory.patch(kept).rows(), static_cast<Eigen::Index>(kept.size()));
}

TEST(TraceMemory, StandstillAndJitterAddNothing) {
  Drive drive;
  drive.to(8.0);
  const auto before = drive.memory.newest(kPatch);
  for (int i = 0; i < 400; ++i) {
    drive.time += 0.05;
    const double jitter = 0.02 * std::sin(0.7 * i);
    const GprTrace trace = drive.radar.measure(drive.ground, 8.0 + jitter, drive.time);
    drive.memory.add(trace.time, trace.samples, trace.sample_interval_s, 8.0 + jitter);
  }
  const auto after = drive.memory.newest(kPatch);
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->centre.distance_m, before->centre.distance_m, 0.05);
  EXPECT_EQ(after->centre.direction, 1);
}

TEST(TraceMemory, LearnsOnlyFromTracesThatVary) {
  Drive drive;
  const std::vector<float> dead(SyntheticGround::kSamples, 0.0F);
  for (int i = 0; i < 700; ++i) {
    drive.memory.add(from_seconds(0.05 * i), dead, SyntheticGround::kSampleInterval, 0.0143 * i);
  }
  EXPECT_FALSE(drive.memory.filter());
  drive.position = 10.0;
  drive.time = 40.0;
  drive.to(16.0);
  ASSERT_TRUE(drive.memory.filter());
  EXPECT_TRUE(drive.memory.newest(kPatch));
}

TEST(TraceMemory, RefusesTracesOfAnotherLengthUntilCleared) {
  Drive drive;
  drive.to(7.0);
  const std::vector<float> shorter(100, 1.0F);
  EXPECT_THROW(drive.memory.add(1, shorter, 0.2e-9, 7.02), std::invalid_argument);
  drive.memory.clear();
  EXPECT_EQ(drive.memory.kept().size(), 0U);
  drive.memory.add(1, shorter, 0.2e-9, 7.02);
}

}  // namespace
}  // namespace gprodom::gpr
