#include "gpr/revisit/global_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "gpr/revisit/band_limit.h"
#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr double kSpacing = 0.02;

Columns drive(unsigned ground_seed, double first, double step, int count, unsigned seed) {
  const SyntheticGround ground(ground_seed);
  SyntheticRadar radar(seed, 60.0);
  Columns traces(count, SyntheticGround::kSamples);
  for (int i = 0; i < count; ++i) {
    const GprTrace trace = radar.measure(ground, first + i * step, 0.05 * i);
    traces.row(i) = Eigen::Map<const Eigen::RowVectorXf>(trace.samples.data(), traces.cols());
  }
  return traces;
}

// Two runs over different ground; what was driven again is found in the right one, both ways, also
// by a wheel that stretches it by a hundredth.
TEST(GlobalSearch, FindsTheRunThePlaceAndTheDirection) {
  const Columns first = drive(1, 1.0, kSpacing, 601, 10), second = drive(2, 1.0, kSpacing, 501, 11);
  const PatchFilter filter(first, kSpacing, SyntheticGround::kSampleInterval);
  GlobalSearch search(filter, kSpacing);
  search.add_run(0, filter.apply(first));
  search.add_run(700, filter.apply(second));  // numbers need not follow each other
  for (const int direction : {1, -1}) {
    for (const double stretch : {1.0, 1.01}) {
      const double middle = 5.0;  // m: column 200 of the second run
      const double step = direction * stretch * kSpacing;
      const Columns query = filter.apply(drive(2, middle - 150 * step, step, 301, 20));
      const GlobalMatch match = search.find({{query, {}}});
      EXPECT_TRUE(match.accepted) << match.margin;
      EXPECT_EQ(match.mirrored, direction < 0);
      EXPECT_NEAR(match.column, 700 + 200, 6) << direction << " " << stretch;
    }
  }
  for (unsigned seed = 30; seed < 40; ++seed) {
    const GlobalMatch match =
        search.find({{filter.apply(drive(seed, 2.0, kSpacing, 301, seed)), {}}});
    EXPECT_TRUE(match.valid);
    EXPECT_FALSE(match.accepted) << seed << " " << match.margin;
  }
}

// Of two queries, one is of other ground. The right one's pulse is ahead by one of the turns tried.
TEST(GlobalSearch, TellsTheQueryThatFitsAndItsTurn) {
  const Columns first = drive(1, 1.0, kSpacing, 601, 10);
  const PatchFilter filter(first, kSpacing, SyntheticGround::kSampleInterval);
  GlobalSearch search(filter, kSpacing);
  search.add_run(0, filter.apply(first));
  const Columns wrong = filter.apply(drive(7, 4.0, kSpacing, 401, 20));
  const Columns right = filter.apply(drive(1, 4.0, kSpacing, 401, 21));
  const auto turned = [&](const Columns& features, double angle) {
    return Columns(features * phase_turn(filter.rows(), angle).transpose());
  };
  for (const double turn : {0.0, 0.8, -0.8}) {
    const Columns now = turned(right, turn);
    const auto asked = [&](const Columns& features) {
      return GlobalQuery{features, turned(features, -0.5 * M_PI)};
    };
    const GlobalMatch match = search.find({asked(wrong), asked(now)});
    EXPECT_TRUE(match.accepted) << turn << " " << match.margin;
    EXPECT_EQ(match.query, 1U);
    EXPECT_EQ(match.turn, turn);
    EXPECT_NEAR(match.column, 150 + 200, 6) << turn;
    EXPECT_LT(search.find({{now, {}}}).score, match.score + 0.5);
  }
}

// The memory is little longer than the query, which lies half outside of it at most places.
TEST(GlobalSearch, ChanceIsThatOfPlacesThatTheMemoryCovers) {
  const Columns first = drive(1, 1.0, kSpacing, 601, 10);
  const PatchFilter filter(first, kSpacing, SyntheticGround::kSampleInterval);
  GlobalSearch search(filter, kSpacing);
  search.add_run(0, filter.apply(first));
  const GlobalMatch match = search.find({{filter.apply(drive(1, 2.0, kSpacing, 451, 20)), {}}});
  EXPECT_GT(match.margin, 3.0);
}

TEST(GlobalSearch, MatchIsInvalidIfNothingCanBeCompared) {
  const Columns traces = drive(1, 1.0, kSpacing, 601, 10);
  const PatchFilter filter(traces, kSpacing, SyntheticGround::kSampleInterval);
  GlobalSearch search(filter, kSpacing);
  const Columns query = filter.apply(traces);
  EXPECT_FALSE(search.find({{query, {}}}).valid);  // nothing is remembered
  search.add_run(0, query);
  EXPECT_FALSE(search.find({{query.topRows(150), {}}}).valid);  // too short
  EXPECT_TRUE(search.find({{query.topRows(300), {}}}).valid);
  EXPECT_THROW(search.add_run(700, query.leftCols(3)), std::invalid_argument);
}

}  // namespace
}  // namespace gprodom::gpr
