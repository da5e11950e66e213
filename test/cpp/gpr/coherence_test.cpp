#include "gpr/motion/coherence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr double kRate = 20.0;  // traces/s
constexpr double kNoise = 60.0;

struct Span {
  double from, to, lengths;
  bool valid;
  int unit;
};

// Stands for some seconds, then goes as `position` says (m, at s since then), to the end of the
// time. The front end is reset at `reset_at` (s since then), and from then on the traces are
// shorter.
std::vector<Span> drive(unsigned seed, double seconds,
                        const std::function<double(double)>& position, double gain = 1.0,
                        double reset_at = 1e6, std::size_t shorter_by = 0, double still = 3.0) {
  const SyntheticGround ground(seed);
  SyntheticRadar radar(seed + 1000, kNoise, gain);
  CoherenceFrontEnd front_end{GprConfig()};
  std::vector<Span> spans;
  for (int i = 0; i < kRate * (still + seconds); ++i) {
    const double t = i / kRate;
    if (i == std::lround(kRate * (still + reset_at))) front_end.reset();
    GprTrace trace = radar.measure(ground, position(std::max(0.0, t - still)), 100 + t);
    if (t >= still + reset_at) trace.samples.resize(trace.samples.size() - shorter_by);
    front_end.add_trace(trace);
    if (i % 2 == 1)
      for (const Finding& finding : front_end.tick(from_seconds(100 + t))) {
        const auto& path = std::get<PathLength>(finding);
        spans.push_back({to_seconds(path.from) - 100 - still, to_seconds(path.to) - 100 - still,
                         path.lengths, path.valid, path.unit});
      }
  }
  return spans;
}

double per_metre(const std::vector<Span>& spans, const std::function<double(double)>& position) {
  double lengths = 0, metres = 0;
  for (const Span& s : spans) {
    if (!s.valid || s.from < 0) continue;
    lengths += s.lengths;
    metres += std::abs(position(s.to) - position(s.from));
  }
  EXPECT_GT(metres, 2.0);
  return lengths / metres;
}

TEST(Coherence, PathLengthIsIndependentOfSpeedDirectionAndGain) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    auto at = [](double speed, double start) {
      return [=](double t) { return start + speed * t; };
    };
    const double reference = per_metre(drive(seed, 20, at(0.4, 2)), at(0.4, 2));
    EXPECT_GT(reference, 5.0);  // a length is some centimetres
    const double slow = per_metre(drive(seed, 40, at(0.2, 2)), at(0.2, 2));
    const double back = per_metre(drive(seed, 20, at(-0.4, 10)), at(-0.4, 10));
    const double loud = per_metre(drive(seed, 20, at(0.4, 2), 0.5), at(0.4, 2));
    EXPECT_NEAR(slow / reference, 1.0, 0.15);
    EXPECT_NEAR(back / reference, 1.0, 0.1);
    EXPECT_NEAR(loud / reference, 1.0, 0.05);
  }
}

// A drive at 0.4 m/s from 0 to 20 s and from 25 to 45 s, after so long a standstill.
std::vector<Span> with_a_stop(double still) {
  const auto position = [](double t) {
    return 2 + 0.4 * (std::min(t, 20.0) + std::max(0.0, t - 25.0));
  };
  return drive(4, 45, position, 1.0, 1e6, 0, still);
}

// What is taken for noise contains the motion until the robot stands for the first time.
TEST(Coherence, UnitIsAnotherAfterTheFirstStopOfADriveThatBeganOnTheMove) {
  const auto mean = [](const std::vector<Span>& all, double from, double to) {
    double lengths = 0.0, spans = 0.0;
    for (const Span& span : all) {
      if (!span.valid || span.from < from || span.from > to) continue;
      lengths += span.lengths;
      ++spans;
    }
    return lengths / std::max(1.0, spans);
  };
  const auto moving = with_a_stop(0.0), rested = with_a_stop(5.0);
  EXPECT_GT(mean(moving, 26, 44), 1.3 * mean(moving, 2, 19)) << "no case of its own";
  for (const Span& span : moving) {
    if (span.from < 19 || span.from > 26) {
      EXPECT_EQ(span.unit == moving.back().unit, span.from > 26) << span.from;
    }
  }
  EXPECT_NEAR(mean(rested, 26, 44) / mean(rested, 2, 19), 1.0, 0.15);
  for (const Span& span : rested) EXPECT_EQ(span.unit, rested.front().unit);
}

// As after a gap in the traces of a robot that drives on, or with traces of another length.
TEST(Coherence, ALengthIsTheSameAfterAReset) {
  auto position = [](double t) { return 2 + 0.4 * t; };
  for (const unsigned seed : {1u, 2u, 3u}) {
    for (const std::size_t shorter_by : {0, 20}) {
      const std::vector<Span> spans = drive(seed, 30, position, 1.0, 10.0, shorter_by);
      std::vector<Span> before, after;
      for (const Span& s : spans) (s.to <= 10.0 ? before : after).push_back(s);
      EXPECT_NEAR(per_metre(after, position) / per_metre(before, position), 1.0, 0.2);
    }
  }
}

TEST(Coherence, FollowsTheSpeedWithinAQuarter) {
  auto position = [](double t) { return 2 + 0.4 * t - 0.6 * std::cos(0.5 * t) + 0.6; };
  for (const unsigned seed : {4u, 5u}) {
    const auto spans = drive(seed, 24, position);
    const double unit = per_metre(spans, position);
    double squares = 0;
    int n = 0;
    for (const Span& s : spans) {
      const double metres = position(s.to) - position(s.from);
      if (!s.valid || s.from < 0 || metres < 0.1) continue;
      squares += std::pow(s.lengths / unit / metres - 1, 2);
      ++n;
    }
    ASSERT_GT(n, 15);
    EXPECT_LT(std::sqrt(squares / n), 0.25);
  }
}

// The radar's gain, time zero and offset change from trace to trace all the while.
TEST(Coherence, ReportsNothingAtAStandstill) {
  auto stop = [](double t) { return 2 + 0.4 * std::min(t, 10.0); };
  int stood = 0, moved = 0;
  for (unsigned seed = 6; seed < 16; ++seed) {
    for (const Span& s : drive(seed, 30, stop)) {
      if (s.to >= 0 && s.from <= 10) continue;
      ++stood;
      moved += s.valid;
    }
  }
  EXPECT_GT(stood, 0);
  EXPECT_LT(moved, 0.01 * 10 * 20);  // of 1 s spans
}

TEST(Coherence, ReportsNothingWithoutGround) {
  SyntheticRadar radar(9, kNoise, 1.0);
  const SyntheticGround bare(9, -10.0);  // no reflectors: the direct wave alone
  CoherenceFrontEnd front_end{GprConfig()};
  for (int i = 0; i < 400; ++i) {
    front_end.add_trace(radar.measure(bare, 0.02 * i, 100 + i / kRate));
    for (const Finding& finding : front_end.tick(from_seconds(100 + i / kRate)))
      EXPECT_FALSE(std::get<PathLength>(finding).valid);
  }
}

// Places a metre apart from trace to trace: neighbours have nothing but the direct wave in common.
TEST(Coherence, IsInvalidIfNeighbouringTracesAreUnlike) {
  for (const unsigned seed : {10u, 11u}) {
    const auto far_apart = [](double t) { return std::fmod(1.07 * kRate * t, 18.0); };
    int spans = 0, valid = 0;
    for (const Span& s : drive(seed, 20, far_apart)) {
      if (s.from < 0.5) continue;
      ++spans;
      valid += s.valid ? 1 : 0;
    }
    EXPECT_GT(spans, 10);
    EXPECT_LE(valid, 0.1 * spans) << seed;
  }
}

}  // namespace
}  // namespace gprodom::gpr
