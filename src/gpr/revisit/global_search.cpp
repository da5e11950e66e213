#include "gpr/revisit/global_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/processor.h"
#include "base/require.h"

namespace gprodom::gpr {
namespace {

// Features have a standard deviation of 1 at most, and means of them less. So the product of two
// pieces of any reasonable length fits 32 bits.
constexpr float kLevelsPerUnit = 200.0F;
constexpr float kLargest = 1000.0F;

constexpr int kAtOnce = 4;  // places

// Sums of products of a query with the memory at kAtOnce places, `stride` numbers apart.
GPRODOM_ALSO_FOR_AVX2
void product_sums(const std::int16_t* a, const std::int16_t* memory, std::ptrdiff_t stride, int n,
                  std::int32_t* sums) {
  std::int32_t a0 = 0, a1 = 0, a2 = 0, a3 = 0;
  const std::int16_t *m0 = memory, *m1 = m0 + stride, *m2 = m1 + stride, *m3 = m2 + stride;
  for (int i = 0; i < n; ++i) {
    a0 += static_cast<std::int32_t>(a[i]) * m0[i];
    a1 += static_cast<std::int32_t>(a[i]) * m1[i];
    a2 += static_cast<std::int32_t>(a[i]) * m2[i];
    a3 += static_cast<std::int32_t>(a[i]) * m3[i];
  }
  sums[0] = a0, sums[1] = a1, sums[2] = a2, sums[3] = a3;
}

std::int32_t product_sum(const std::int16_t* a, const std::int16_t* b, std::size_t n) {
  return std::inner_product(a, a + n, b, std::int32_t{0});
}

GPRODOM_ALSO_FOR_AVX2
void keep_larger(const float* other, std::size_t n, float* values) {
  for (std::size_t i = 0; i < n; ++i) values[i] = std::max(values[i], other[i]);
}

// Adds to sum[i] the highest of at[i + from] to at[i + to], times a share.
void add_highest(const std::vector<float>& at, std::ptrdiff_t from, std::ptrdiff_t to, float share,
                 std::vector<float>& sum) {
  const auto total = static_cast<std::ptrdiff_t>(at.size());
  std::vector<float> best(at.size(), 0.0F);  // nothing is known where the memory ends
  for (std::ptrdiff_t by = from; by <= to; ++by) {
    const auto begin = std::max<std::ptrdiff_t>(0, -by), end = std::min(total, total - by);
    if (begin < end)
      keep_larger(&at[static_cast<std::size_t>(begin + by)], static_cast<std::size_t>(end - begin),
                  &best[static_cast<std::size_t>(begin)]);
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += share * best[i];
}

}  // namespace

GlobalSearch::GlobalSearch(const PatchFilter& filter, double spacing,
                           const GlobalSearchOptions& options)
    : options_(options),
      spacing_(spacing),
      feature_rows_(filter.rows()),
      piece_(static_cast<int>(std::lround(options.piece_m / (spacing * options.thinning)))) {
  require(options.thinning >= 1 && options.rows >= 1 && piece_ >= 4,
          "global search: expected pieces of four thinned columns or more");
  options_.rows = std::min(options_.rows, feature_rows_);
  energy_.push_back(0.0);
}

GlobalSearch::Thinned GlobalSearch::thin(const Columns& features) const {
  const auto columns = features.rows() / options_.thinning;
  Thinned thinned;
  thinned.reserve(static_cast<std::size_t>(columns * options_.rows));
  for (Eigen::Index i = 0; i < columns; ++i) {
    const Eigen::RowVectorXf mean =
        features.middleRows(i * options_.thinning, options_.thinning).colwise().mean();
    for (int row = 0; row < options_.rows; ++row) {
      const float feature = mean[(2 * row + 1) * feature_rows_ / (2 * options_.rows)];
      thinned.push_back(static_cast<std::int16_t>(
          std::lround(std::clamp(kLevelsPerUnit * feature, -kLargest, kLargest))));
    }
  }
  return thinned;
}

void GlobalSearch::add_run(std::size_t first, const Columns& features) {
  require(features.cols() == feature_rows_,
          "global search: expected as many rows as the filter gives");
  const Thinned run = thin(features);
  const auto rows = static_cast<std::size_t>(options_.rows);
  runs_.push_back({first, memory_.size() / rows});
  memory_.insert(memory_.end(), run.begin(), run.end());
  for (std::size_t i = 0; i < run.size(); i += rows) {
    energy_.push_back(energy_.back() + product_sum(&run[i], &run[i], options_.rows));
  }
}

// Correlation of a piece of the query with the memory at each thinned column, for each turn.
std::vector<std::vector<float>> GlobalSearch::correlations(const Turned& query, int piece) const {
  const auto rows = static_cast<std::size_t>(options_.rows);
  const std::size_t n = static_cast<std::size_t>(piece_) * rows;
  const std::int16_t* a = &query.as_it_is[static_cast<std::size_t>(piece) * n];
  const std::int16_t* b =
      query.quarter.empty() ? nullptr : &query.quarter[static_cast<std::size_t>(piece) * n];
  const std::size_t total = energy_.size() - 1;
  const std::size_t turns = b == nullptr ? 1 : options_.turns.size();
  std::vector<std::vector<float>> result(turns, std::vector<float>(total, 0.0F));
  const double own = product_sum(a, a, n);
  const double of_quarter = b == nullptr ? 0.0 : product_sum(b, b, n);
  const double both = b == nullptr ? 0.0 : product_sum(a, b, n);
  std::vector<float> cosine(turns, own > 0.0 ? static_cast<float>(1.0 / std::sqrt(own)) : 0.0F);
  std::vector<float> sine(turns, 0.0F);
  for (std::size_t t = 0; b != nullptr && t < turns; ++t) {
    const double c = std::cos(options_.turns[t]), s = std::sin(options_.turns[t]);
    const double energy = c * c * own + s * s * of_quarter + 2 * c * s * both;
    cosine[t] = energy > 0.0 ? static_cast<float>(c / std::sqrt(energy)) : 0.0F;
    sine[t] = energy > 0.0 ? static_cast<float>(s / std::sqrt(energy)) : 0.0F;
  }
  const auto length = static_cast<std::size_t>(piece_);
  for (std::size_t i = 0; i + length <= total; i += kAtOnce) {
    std::int32_t of_a[kAtOnce] = {}, of_b[kAtOnce] = {};
    const std::size_t places = std::min<std::size_t>(kAtOnce, total - length + 1 - i);
    const std::int16_t* memory = &memory_[i * rows];
    const auto stride = static_cast<std::ptrdiff_t>(rows);
    if (places < kAtOnce) {
      for (std::size_t k = 0; k < places; ++k) {
        of_a[k] = product_sum(a, memory + k * rows, n);
        if (b != nullptr) of_b[k] = product_sum(b, memory + k * rows, n);
      }
    } else {
      product_sums(a, memory, stride, static_cast<int>(n), of_a);
      if (b != nullptr) product_sums(b, memory, stride, static_cast<int>(n), of_b);
    }
    for (std::size_t k = 0; k < places; ++k) {
      const double energy = energy_[i + k + length] - energy_[i + k];
      const float scale = energy > 0.0 ? static_cast<float>(1.0 / std::sqrt(energy)) : 0.0F;
      for (std::size_t t = 0; t < turns; ++t) {
        result[t][i + k] = scale * (cosine[t] * static_cast<float>(of_a[k]) +
                                    sine[t] * static_cast<float>(of_b[k]));
      }
    }
  }
  return result;
}

// Score for each thinned column under the query's centre, for each turn: the mean correlation of
// the pieces, each at the best place within its slack.
std::vector<std::vector<float>> GlobalSearch::scores(const Turned& query) const {
  const auto rows = static_cast<std::size_t>(options_.rows);
  const auto columns = static_cast<int>(query.as_it_is.size() / rows);
  const int pieces = columns / piece_;
  std::vector<std::vector<float>> sum;
  for (int p = 0; p < pieces; ++p) {
    const std::vector<std::vector<float>> at = correlations(query, p);
    sum.resize(at.size(), std::vector<float>(energy_.size() - 1, 0.0F));
    // From the query's centre to the piece's first thinned column, in the order of the memory.
    const int offset = p * piece_ - pieces * piece_ / 2;
    const int slack = static_cast<int>(std::ceil(options_.slack * std::abs(offset + 0.5 * piece_)));
    for (std::size_t t = 0; t < at.size(); ++t) {
      add_highest(at[t], offset - slack, offset + slack, 1.0F / static_cast<float>(pieces), sum[t]);
    }
  }
  return sum;
}

double GlobalSearch::column_of(std::size_t thinned) const {
  const auto run =
      std::prev(std::upper_bound(runs_.begin(), runs_.end(), thinned,
                                 [](std::size_t n, const Run& r) { return n < r.begin; }));
  return static_cast<double>(run->first) +
         options_.thinning * static_cast<double>(thinned - run->begin);
}

// The highest score of a place other than the best one.
double GlobalSearch::second(const std::vector<float> (&score)[2], std::size_t best, bool mirrored,
                            const SamePlace& same_place) const {
  const auto apart =
      static_cast<std::ptrdiff_t>(std::ceil(options_.distinct_m / (spacing_ * options_.thinning)));
  double second = -1.0;
  for (int d = 0; d < 2; ++d) {
    for (std::size_t i = 0; i < score[d].size(); ++i) {
      if (score[d][i] <= second) continue;
      const auto from_best = static_cast<std::ptrdiff_t>(i) - static_cast<std::ptrdiff_t>(best);
      if ((d == 1) == mirrored && std::abs(from_best) < apart) continue;
      if (same_place && same_place(column_of(best), column_of(i))) continue;
      second = score[d][i];
    }
  }
  return second;
}

// Compares one query in both directions, and adds its scores to those of the others.
void GlobalSearch::add(const GlobalQuery& query, std::size_t number, Survey& survey,
                       GlobalMatch& match) const {
  for (int d = 0; d < 2; ++d) {
    const auto thinned = [&](const Columns& columns) {
      return d == 0 ? thin(columns) : thin(columns.colwise().reverse());
    };
    Turned turned{thinned(query.features), {}};
    if (query.quarter.size() > 0) turned.quarter = thinned(query.quarter);
    const std::vector<std::vector<float>> score = scores(turned);
    for (std::size_t t = 0; t < score.size(); ++t) {
      for (std::size_t i = survey.first; i < survey.end; ++i) {
        survey.sum += score[t][i];
        survey.squares += score[t][i] * score[t][i];
      }
      survey.count += static_cast<double>(survey.end - survey.first);
      keep_larger(score[t].data(), score[t].size(), survey.highest[d].data());
      const auto top = std::max_element(score[t].begin(), score[t].end());
      if (*top <= survey.best) continue;
      survey.best = *top;
      survey.place = static_cast<std::size_t>(top - score[t].begin());
      match.mirrored = d == 1;
      match.query = number;
      match.turn = turned.quarter.empty() ? 0.0 : options_.turns[t];
    }
  }
}

GlobalMatch GlobalSearch::find(const std::vector<GlobalQuery>& queries,
                               const SamePlace& same_place) const {
  GlobalMatch match;
  if (queries.empty() || runs_.empty()) return match;
  const Eigen::Index columns = queries.front().features.rows();
  const auto pieces = columns / options_.thinning / piece_;
  if (pieces < 2 || queries.front().features.cols() != feature_rows_) return match;

  const auto total = energy_.size() - 1;
  const auto half = static_cast<std::size_t>(pieces * piece_ / 2);
  Survey survey;
  const bool covers = 2 * half < total;
  survey.first = covers ? half : 0;
  survey.end = covers ? total - half : total;
  for (auto& highest : survey.highest) highest.resize(total, -1.0F);
  for (std::size_t q = 0; q < queries.size(); ++q) add(queries[q], q, survey, match);

  const double mean = survey.sum / survey.count;
  const double chance = std::sqrt(std::max(1e-12, survey.squares / survey.count - mean * mean));
  const double other = second(survey.highest, survey.place, match.mirrored, same_place);
  match.valid = true;
  match.score = (survey.best - mean) / chance;
  match.margin = (survey.best - other) / chance;
  match.accepted = match.margin >= options_.min_margin;
  // The place is the middle one of the thinned columns that the pieces cover, from the query's
  // start.
  const Eigen::Index thinned_before = pieces * piece_ / 2;
  const auto before = static_cast<double>(thinned_before * options_.thinning);
  match.column = column_of(survey.place) - before + 0.5 * static_cast<double>(columns - 1);
  return match;
}

std::size_t GlobalSearch::bytes() const {
  return memory_.size() * sizeof(std::int16_t) + energy_.size() * sizeof(double) +
         runs_.size() * sizeof(Run);
}

}  // namespace gprodom::gpr
