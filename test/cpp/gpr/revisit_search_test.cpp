#include "gpr/revisit/revisit_search.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gpr/kernels/add_multiple.h"
#include "gpr/revisit/band_limit.h"
#include "gpr/revisit/matrix_product.h"
#include "gpr/revisit/patch_filter.h"
#include "gpr/revisit/row_sums.h"
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

// What the search for revisits computes with, against the plain formulas.

// Shorter than a register, some whole ones, and some with a rest.
TEST(AddMultiple, IsThatOfEachEntryWhateverTheLength) {
  for (const int n : {1, 7, 16, 37}) {
    const Eigen::VectorXf of = Eigen::VectorXf::Random(n), before = Eigen::VectorXf::Random(n + 2);
    Eigen::VectorXf to = before;
    add_multiple(-0.3F, of.data(), n, &to[1]);
    for (int i = 0; i < n; ++i) EXPECT_FLOAT_EQ(to[i + 1], before[i + 1] - 0.3F * of[i]);
    EXPECT_EQ(to[0], before[0]);
    EXPECT_EQ(to[n + 1], before[n + 1]);
  }
}

// Below a tile, one tile, and a length that is no multiple of it; of rows, and of one row again and
// again.
TEST(RowSums, AddsPiecesOfRows) {
  constexpr int kRows = 3, kStride = 120;
  std::vector<float> table(kRows * kStride);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i % 37);
  const int begin[kRows] = {5, 0, 13};
  for (const int stride : {kStride, 0})
    for (const int n : {1, 31, 32, 77}) {
      std::vector<float> sum(n, -1.0F);
      sum_rows(table.data(), stride, begin, kRows, n, sum.data());
      for (int k = 0; k < n; ++k) {
        float expected = 0.0F;
        for (int i = 0; i < kRows; ++i) expected += table[i * stride + begin[i] + k];
        EXPECT_EQ(sum[k], expected) << stride << " " << n << " " << k;
      }
    }
}

TEST(MatrixProduct, IsThatOfEigenWhateverTheSizes) {
  for (const int m : {1, 5, 6, 13}) {
    for (const int n : {1, 8, 11}) {
      for (const int k : {1, 7}) {
        const Columns all_a = Columns::Random(m, k + 3), all_b = Columns::Random(n, k + 3);
        const auto a = all_a.middleCols(2, k), b = all_b.middleCols(1, k);  // with strides
        Columns out = Columns::Constant(m, n + 2, 7.0F);
        multiply_by_rows(a, b, out);
        EXPECT_LT((out.leftCols(n) - a * b.transpose()).cwiseAbs().maxCoeff(), 1e-5F);
        EXPECT_TRUE((out.rightCols(2).array() == 7.0F).all());  // what is beyond stays
      }
    }
  }
}

// Mean of the rows that are within `half` of each row.
Columns mean_of_neighbours(const Columns& in, Eigen::Index half) {
  Columns out(in.rows(), in.cols());
  for (Eigen::Index i = 0; i < in.rows(); ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - half);
    const Eigen::Index last = std::min(in.rows() - 1, i + half);
    out.row(i) = in.middleRows(first, last - first + 1).colwise().mean();
  }
  return out;
}

// A sigma of 3 columns is that of three means over 3 columns to either side. Fewer columns than
// that, and more.
TEST(PatchFilter, SmoothsByThreeRunningMeans) {
  for (const int n : {1, 2, 4, 7, 40}) {
    const Columns columns = Columns::Random(n, 11);
    Columns expected = columns;
    for (int pass = 0; pass < 3; ++pass) expected = mean_of_neighbours(expected, 3);
    Columns smooth = columns;
    smooth_along(3.0, smooth);
    EXPECT_LT((smooth - expected).cwiseAbs().maxCoeff(), 1e-6F) << n;
  }
}

// Away from the ends, over the periods that features have.
TEST(PhaseTurn, TurnsEachFrequencyByTheAngle) {
  constexpr int kRows = 80, kEnd = 20;
  for (const double angle : {-0.7, 0.4, 1.2, 0.5 * M_PI}) {
    const Columns turn = phase_turn(kRows, angle);
    for (const double period : {2.5, 4.0, 7.0, 11.0}) {
      Columns wave(1, kRows);
      for (int row = 0; row < kRows; ++row)
        wave(0, row) = static_cast<float>(std::cos(2 * M_PI * row / period));
      const Columns turned = wave * turn.transpose();
      for (int row = kEnd; row < kRows - kEnd; ++row) {
        EXPECT_NEAR(turned(0, row), std::cos(2 * M_PI * row / period + angle), 0.08)
            << angle << " " << period << " " << row;
      }
    }
  }
}

}  // namespace
}  // namespace gprodom::gpr
