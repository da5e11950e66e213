#include "gpr/revisit/revisit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "gpr/revisit/band_limit.h"
#include "gpr/revisit/global_search.h"
#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr double kSpacing = 0.02;
constexpr int kPatch = 92;  // columns, 1.82 m from the first to the last
constexpr double kNoise = 60.0;

// Traces from `first` m on, `step` m apart (negative: driven the other way).
Columns drive(const SyntheticGround& ground, double first, double step, int count, unsigned seed) {
  return measured(ground, seed, kNoise, count, [=](int i) { return first + i * step; });
}

class Revisit : public ::testing::Test {
 protected:
  Revisit()
      : ground_(1),
        memory_traces_(drive(ground_, 2.0, kSpacing, 601, 10)),
        filter_(memory_traces_, kSpacing, SyntheticGround::kSampleInterval),
        memory_(filter_.apply(memory_traces_)) {}

  // A patch of `ground` whose centre lies at `centre` m; the memory's centre lies at 8 m.
  RevisitMatch match(const SyntheticGround& ground, double centre, double step, unsigned seed,
                     double bound = 0.6, RevisitOptions options = {}) {
    const double first = centre - 0.5 * (kPatch - 1) * step;
    const Columns query = filter_.apply(drive(ground, first, step, kPatch, seed));
    return PatchMatcher(filter_, kSpacing, std::move(options))
        .match(memory_, query, centre - 8.0 + 0.2, bound);
  }

  SyntheticGround ground_;
  Columns memory_traces_;
  PatchFilter filter_;
  Columns memory_;
};

TEST_F(Revisit, KnownOffsetsAreFoundBetweenColumnsInBothDirections) {
  double squares = 0.0, ratios = 0.0;
  int n = 0;
  for (double centre = 4.0; centre < 12.0; centre += 0.4537) {
    for (const int direction : {1, -1}) {
      const RevisitMatch found = match(ground_, centre, direction * kSpacing, 100U + n);
      ASSERT_TRUE(found.accepted) << centre << " " << direction << " score " << found.score;
      EXPECT_EQ(found.mirrored, direction < 0);
      EXPECT_EQ(found.scale, 1.0);
      const double error = found.offset_m - (centre - 8.0);
      EXPECT_LT(std::abs(error), 0.25 * kSpacing) << centre;
      squares += error * error;
      ratios += error * error / (found.sigma_m * found.sigma_m);
      ++n;
    }
  }
  EXPECT_LT(std::sqrt(squares / n), 0.1 * kSpacing);
  // Chi-square over n, for n = 36: 0.3 to 2.2 leaves room for errors of the model.
  EXPECT_GT(ratios / n, 0.3);
  EXPECT_LT(ratios / n, 2.2);
}

TEST_F(Revisit, AStretchedPatchIsFoundByTheScaleSearch) {
  RevisitOptions unscaled;
  unscaled.scales = {1.0};
  // Columns that are 2 cm apart by a wheel that reports too little.
  const RevisitMatch found = match(ground_, 7.0, 1.03 * kSpacing, 7);
  EXPECT_TRUE(found.accepted);
  EXPECT_NEAR(found.scale, 1.03, 0.011);
  EXPECT_NEAR(found.offset_m, -1.0, 0.5 * kSpacing);
  EXPECT_GT(found.correlation, match(ground_, 7.0, 1.03 * kSpacing, 7, 0.6, unscaled).correlation);
}

TEST_F(Revisit, OtherGroundIsRejected) {
  for (unsigned seed = 20; seed < 60; ++seed) {
    const RevisitMatch found =
        match(SyntheticGround(seed), 5.0 + 0.15 * (seed - 20), kSpacing, seed);
    EXPECT_TRUE(found.valid);
    EXPECT_FALSE(found.accepted) << "seed " << seed << " score " << found.score;
  }
}

TEST_F(Revisit, GroundThatRepeatsIsNotAccepted) {
  // One stretch of 0.5 m, repeated: every place equals the one 0.5 m further on.
  Columns repeated(601, memory_traces_.cols());
  for (int i = 0; i < 601; ++i) repeated.row(i) = memory_traces_.row(100 + i % 25);
  const PatchFilter filter(repeated, kSpacing, SyntheticGround::kSampleInterval);
  const Columns memory = filter.apply(repeated);
  const Columns query = memory.middleRows(200, kPatch);
  const RevisitMatch found = PatchMatcher(filter, kSpacing).match(memory, query, -1.0, 0.6);
  EXPECT_TRUE(found.valid);
  EXPECT_FALSE(found.accepted) << found.score;
}

TEST_F(Revisit, AGlitchedTraceDoesNotMatter) {
  Columns traces = drive(ground_, 6.0, kSpacing, kPatch, 3);
  traces.row(40).setConstant(3e5F);
  const RevisitMatch found =
      PatchMatcher(filter_, kSpacing).match(memory_, filter_.apply(traces), -1.0, 0.6);
  EXPECT_TRUE(found.accepted);
  EXPECT_NEAR(found.offset_m, 6.0 + 0.5 * (kPatch - 1) * kSpacing - 8.0, 0.25 * kSpacing);
}

// Two columns of a glitch that are equal, 30 times as large as the ground, do not make a place.
TEST_F(Revisit, OneColumnThatIsFarLargerDecidesNothing) {
  Columns query =
      filter_.apply(drive(ground_, 8.0 - 0.5 * (kPatch - 1) * kSpacing, kSpacing, kPatch, 3));
  query.row(30) = 30.0F * memory_.row(100);
  Columns memory = memory_;
  memory.row(300) = query.row(30);  // where the query's centre would lie 0.32 m further
  const RevisitMatch found = PatchMatcher(filter_, kSpacing).match(memory, query, 0.2, 0.6);
  EXPECT_TRUE(found.accepted) << found.score;
  EXPECT_NEAR(found.offset_m, 0.0, kSpacing);
}

TEST_F(Revisit, PlacesOutsideTheMemoryAreNotCompared) {
  PatchMatcher matcher(filter_, kSpacing);
  const Columns query = memory_.topRows(kPatch);
  EXPECT_FALSE(matcher.match(memory_, query, 20.0, 0.6).valid);
  EXPECT_FALSE(matcher.match(memory_.topRows(kPatch - 1), query, 0.0, 0.6).valid);
  EXPECT_NEAR(matcher.match(memory_, query, -5.1, 0.6).offset_m, -0.5 * (601 - kPatch) * kSpacing,
              1e-3);
  EXPECT_THROW(matcher.match(memory_.leftCols(5), query, 0.0, 0.6), std::invalid_argument);
}

TEST(PatchFilter, RefusesTracesItCannotLearnFrom) {
  const Columns flat = Columns::Ones(100, 201);
  EXPECT_THROW(PatchFilter(flat, kSpacing, 0.2e-9), std::invalid_argument);
  EXPECT_THROW(PatchFilter(flat.topRows(5), kSpacing, 0.2e-9), std::invalid_argument);
  Columns broken = Columns::Random(100, 201);
  EXPECT_THROW(PatchFilter(broken, 0.0, 0.2e-9), std::invalid_argument);
  broken(3, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(PatchFilter(broken, kSpacing, 0.2e-9), std::invalid_argument);
}

TEST(PatchFilter, FeaturesAreFewEnoughForTheMemory) {
  const SyntheticGround ground(1);
  const PatchFilter filter(drive(ground, 2.0, kSpacing, 300, 1), kSpacing, 0.2e-9);
  EXPECT_LE(filter.rows(), 96);
  EXPECT_GT(filter.centre_frequency(), 350e6);
  EXPECT_LT(filter.centre_frequency(), 650e6);
}

// The receiver's zero drifts from trace to trace, with an amplitude above that of deep echoes.
TEST(PatchFilter, SlowDriftOfTheReceiverIsRemoved) {
  Columns traces = drive(SyntheticGround(1), 2.0, kSpacing, 300, 1);
  const double quiet = PatchFilter(traces, kSpacing, 0.2e-9).centre_frequency();
  Columns features = PatchFilter(traces, kSpacing, 0.2e-9).apply(traces);
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0.0F, 300.0F);
  const Eigen::RowVectorXf ramp = Eigen::RowVectorXf::LinSpaced(traces.cols(), 0.5F, 1.0F);
  for (int i = 0; i < traces.rows(); i += 10) {
    const float swing = normal(random);  // for 20 cm
    traces.middleRows(i, 10).rowwise() += swing * ramp;
  }
  const PatchFilter filter(traces, kSpacing, 0.2e-9);
  EXPECT_NEAR(filter.centre_frequency(), quiet, 0.1 * quiet);
  const Columns swinging = filter.apply(traces);
  ASSERT_EQ(swinging.cols(), features.cols());
  const double common = features.cwiseProduct(swinging).sum();
  EXPECT_GT(common, 0.9 * features.norm() * swinging.norm());
}

Columns drive(unsigned ground, double first, double step, int count, unsigned seed) {
  return drive(SyntheticGround(ground), first, step, count, seed);
}

// One run is remembered.
struct OneRun : testing::Test {
  OneRun() { search.add_run(0, filter.apply(first)); }
  const Columns first = drive(1, 1.0, kSpacing, 601, 10);
  const PatchFilter filter{first, kSpacing, SyntheticGround::kSampleInterval};
  GlobalSearch search{filter, kSpacing};
};

// Two runs over different ground; what was driven again is found in the right one, both ways, also
// by a wheel that stretches it by a hundredth.
TEST_F(OneRun, FindsAnotherRunThePlaceAndTheDirection) {
  // Numbers need not follow each other.
  search.add_run(700, filter.apply(drive(2, 1.0, kSpacing, 501, 11)));
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
TEST_F(OneRun, TellsTheQueryThatFitsAndItsTurn) {
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
TEST_F(OneRun, ChanceIsThatOfPlacesThatTheMemoryCovers) {
  const GlobalMatch match = search.find({{filter.apply(drive(1, 2.0, kSpacing, 451, 20)), {}}});
  EXPECT_GT(match.margin, 3.0);
}

TEST_F(OneRun, MatchIsInvalidIfNothingCanBeCompared) {
  const Columns query = filter.apply(first);
  EXPECT_FALSE(GlobalSearch(filter, kSpacing).find({{query, {}}}).valid);  // nothing is remembered
  EXPECT_FALSE(search.find({{query.topRows(150), {}}}).valid);             // too short
  EXPECT_TRUE(search.find({{query.topRows(300), {}}}).valid);
  EXPECT_THROW(search.add_run(700, query.leftCols(3)), std::invalid_argument);
}

}  // namespace
}  // namespace gprodom::gpr
