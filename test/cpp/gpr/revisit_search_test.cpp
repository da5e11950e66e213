#include "gpr/revisit/revisit_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr double kSpacing = 0.02;
constexpr double kNoise = 60.0;

// Traces at the columns `place(i)` of ground that begins 2 m on, without noise.
template <class Place>
Columns ground(unsigned seed, int count, Place place) {
  const SyntheticGround synthetic(seed);
  return measured(synthetic, seed, 0.0, count, [&](int i) { return 2.0 + place(i) * kSpacing; });
}

Columns ground(unsigned seed, int count) {
  return ground(seed, count, [](int i) { return i; });
}

Columns noisy(Columns traces, unsigned seed, double noise = kNoise) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.0F, static_cast<float>(noise));
  return traces +
         Columns::NullaryExpr(traces.rows(), traces.cols(), [&] { return normal(random); });
}

// What is remembered of ground, and the filter learnt from it.
struct Known {
  explicit Known(Columns of) : traces(std::move(of)) {}
  Columns traces;
  Columns seen = noisy(traces, 1);
  PatchFilter filter{seen, kSpacing, SyntheticGround::kSampleInterval};
  Columns memory = filter.apply(seen);
};

// Drives over `queries` (features, in the order driven) and searches the memory every 12 columns.
// The expected place is wrong by `off` columns. place(i): the true column of query i. slip:
// standard deviation of the stretch.
struct Outcome {
  int found = 0, wrong = 0, first = -1, last = -1;  // the query's last column when first found
  std::vector<double> scores;                       // of the places found
};
template <class Place>
Outcome drive(const Known& known, const Columns& queries, int off, Place place, double slip = 0.0,
              double bound_m = 0.8, const RevisitSearchOptions& options = {}, double grip = 0.0) {
  RevisitSearch search(known.filter, kSpacing, options);
  const int patch = search.patch_columns();
  constexpr int kStep = 12;
  Outcome outcome;
  for (int end = patch; end <= queries.rows(); end += kStep) {
    const double truth = place(end - 0.5 * (patch + 1));
    SearchWindow window;
    window.features = known.memory;
    window.expected = truth + off;
    window.bound_m = bound_m;
    window.stretch_sigma = slip;
    window.stretch_change = grip > 0.0 ? 0.02 : 0.25 * slip;
    window.grip = grip;
    window.kept = grip > 0.0 ? 0.95 : 1.0;
    const int before = std::min(end, patch + 50);
    for (const PlaceFound& found :
         search.find(queries.middleRows(end - before, before), kStep * kSpacing, {window})) {
      ++outcome.found;
      if (outcome.first < 0) outcome.first = end;
      outcome.last = end;
      outcome.scores.push_back(found.match.score);
      if (std::abs(found.column - truth) > 1.5) ++outcome.wrong;
    }
  }
  return outcome;
}

TEST(RevisitSearch, GroundSeenBeforeIsFoundInBothDirections) {
  const Known known(ground(1, 601));
  const Columns queries = known.filter.apply(noisy(known.traces, 2)).middleRows(100, 400);
  const Outcome forwards = drive(known, queries, 15, [](double i) { return 100 + i; });
  EXPECT_GT(forwards.found, 20);
  EXPECT_EQ(forwards.wrong, 0);
  const Outcome back =
      drive(known, queries.colwise().reverse(), -15, [](double i) { return 499 - i; });
  EXPECT_GT(back.found, 20);
  EXPECT_EQ(back.wrong, 0);
}

// Patches that are each a little more alike at one place make it certain in the end, whether it is
// the right one or not.
TEST(RevisitSearch, APlaceIsToldFromAPatchOnThatIsClearByItself) {
  const Known known(ground(1, 601));
  const Columns queries = known.filter.apply(noisy(known.traces, 2)).middleRows(100, 400);
  const auto place = [](double i) { return 100 + i; };
  const Outcome all = drive(known, queries, 15, place);
  const auto clearest = std::max_element(all.scores.begin(), all.scores.end());
  ASSERT_GT(clearest - all.scores.begin(), 2);
  ASSERT_GT(all.scores.end() - clearest, 2);

  RevisitSearchOptions options;
  options.matcher.min_score = *clearest;
  const Outcome later = drive(known, queries, 15, place, 0.0, 0.8, options);
  EXPECT_EQ(later.found, all.scores.end() - clearest);
  options.matcher.min_score = 1.01 * *clearest;
  EXPECT_EQ(drive(known, queries, 15, place, 0.0, 0.8, options).found, 0);
}

// Beside a place that is certain, only little ground is compared. So after a jump of the odometry
// the place lies beyond it, and must be found again.
TEST(RevisitSearch, ACertainPlaceIsGivenUpAfterAJump) {
  const Known known(ground(1, 601));
  const auto place = [](double i) { return i < 150 ? 20 + i : 120 + i; };  // a jump of 2 m
  const Columns queries = known.filter.apply(noisy(ground(1, 400, place), 2));
  const Outcome outcome = drive(known, queries, 0, place, 0.0, 4.0);
  EXPECT_LE(outcome.first, 150);
  EXPECT_GE(outcome.last, 380);
  EXPECT_GT(outcome.found, 12);
  EXPECT_EQ(outcome.wrong, 0);
}

TEST(RevisitSearch, OtherGroundIsNotFound) {
  const Known known(ground(1, 601));
  const auto place = [](double i) { return 100 + i; };
  for (unsigned seed = 2; seed < 22; ++seed) {
    const Columns other = known.filter.apply(noisy(ground(seed, 400), seed));
    for (const double slip : {0.0, 0.4}) {
      EXPECT_EQ(drive(known, other, 0, place, slip).found, 0) << seed << " " << slip;
    }
  }
}

// A wheel that slips lays the same ground out over another length. Held, and coming on while the
// place is known.
TEST(RevisitSearch, StretchedGroundIsFoundIfTheWheelMaySlip) {
  const Known known(ground(1, 601));
  for (const double stretch : {-0.35, 0.22}) {
    const double ratio = std::exp(stretch);
    const auto held = [&](double i) { return 60 + ratio * i; };
    const auto coming_on = [&](double i) {
      const double since = std::clamp(i - 100.0, 0.0, 100.0);  // over 2 m
      return 60 + i + (ratio - 1) * (since * since / 200.0 + std::max(0.0, i - 200.0));
    };
    const auto check = [&](const auto& place, int least) {
      const Columns queries = known.filter.apply(noisy(ground(1, 400, place), 2));
      const Outcome found = drive(known, queries, 10, place, 0.3);
      EXPECT_GE(found.found, least) << stretch;
      EXPECT_EQ(found.wrong, 0) << stretch;
      const auto back = [&](double i) { return place(399 - i); };
      const Outcome mirrored = drive(known, queries.colwise().reverse(), -10, back, 0.3);
      EXPECT_GE(mirrored.found, least) << stretch;
      EXPECT_EQ(mirrored.wrong, 0) << stretch;
    };
    check(held, 15);
    check(coming_on, 15);
  }
}

// Where a pass begins to lie on known ground, none of its patch has counted before.
TEST(RevisitSearch, WhereAPassBeginsIsFoundWithinAPatch) {
  const Known known(ground(1, 801));
  const Columns other = noisy(ground(7, 300), 3),
                again = noisy(known.traces.middleRows(300, 400), 2, 12.0 * kNoise);
  Columns queries(700, known.traces.cols());
  queries << other, again;
  const auto place = [](double i) { return i; };
  for (const double slip : {0.0, 0.3}) {
    const Outcome outcome = drive(known, known.filter.apply(queries), 10, place, slip, 2.0);
    EXPECT_EQ(outcome.wrong, 0) << slip;
    EXPECT_GE(outcome.first, 330) << slip;
    EXPECT_LE(outcome.first, 300 + 92 + 12) << slip;  // a patch, and one search
  }
}

// Most wheels grip most of the time. A search that knows it finds weak likeness, and slip as well.
TEST(RevisitSearch, GripIsLikelierThanAnyOneSlip) {
  const Known known(ground(1, 601));
  constexpr double kWeak = 16.0;
  const auto found = [&](double ratio, double grip) {
    int sum = 0;
    for (unsigned seed = 2; seed < 8; ++seed) {
      const auto place = [&](double i) { return 60 + ratio * i; };
      const Columns queries = noisy(ground(1, 400, place), seed, kWeak * kNoise);
      const Outcome outcome =
          drive(known, known.filter.apply(queries), 10, place, 0.5, 1.5, {}, grip);
      EXPECT_EQ(outcome.wrong, 0) << ratio;
      sum += outcome.found;
    }
    return sum;
  };
  EXPECT_GT(found(1.0, 0.5), 1.2 * found(1.0, 0.0));
  EXPECT_GT(found(0.75, 0.5), 0.8 * found(0.75, 0.0));
}

// Bars at an even pitch of half a metre, with one irregular stretch between them. With only bars
// behind it, the robot may be at any of them. The stretch decides, and the decision is kept along
// the bars after it.
TEST(RevisitSearch, RepeatingGroundIsDecidedByItsIrregularStretch) {
  const Columns one = ground(1, 601);
  Columns traces(801, one.cols());
  for (int i = 0; i < 801; ++i) traces.row(i) = one.row(100 + i % 25);
  traces.middleRows(400, 40) = one.middleRows(300, 40);
  const Known known(traces);
  const Columns queries = known.filter.apply(noisy(traces, 2)).middleRows(100, 600);
  const auto place = [](double i) { return 100 + i; };
  for (const int off : {-20, 0, 20}) {
    EXPECT_EQ(drive(known, queries, off, place, 0.3).wrong, 0) << off;
    const Outcome outcome = drive(known, queries, off, place);
    EXPECT_EQ(outcome.wrong, 0) << off;
    EXPECT_GE(outcome.found, 6) << off;
    EXPECT_GE(outcome.first, 300) << off;  // the stretch begins at column 300 of the queries
  }
  // In the last third of the drive the stretch has left the query.
  const Columns after = queries.bottomRows(150);
  EXPECT_EQ(drive(known, after, 0, [](double i) { return 550 + i; }).found, 0);
}

}  // namespace
}  // namespace gprodom::gpr
