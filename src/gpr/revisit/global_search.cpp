#include "gpr/revisit/global_search.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/processor.h"

namespace gprodom::gpr {
namespace {

// Features have a standard deviation of 1 at most, and means of them less. So the product of two
// pieces of any reasonable length fits 32 bits.
constexpr float kLevelsPerUnit = 200.0F;
constexpr float kLargest = 1000.0F;

// Sum of products.
GPRODOM_ALSO_FOR_AVX2
std::int32_t product_sum(const std::int16_t* a, const std::int16_t* b, int n) {
  std::int32_t sum = 0;
  for (int i = 0; i < n; ++i) sum += static_cast<std::int32_t>(a[i]) * b[i];
  return sum;
}

}  // namespace

GlobalSearch::GlobalSearch(const PatchFilter& filter, double spacing, GlobalSearchOptions options)
    : options_(options),
      spacing_(spacing),
      feature_rows_(filter.rows()),
      piece_(static_cast<int>(std::lround(options.piece_m / (spacing * options.thinning)))) {
  if (options.thinning < 1 || options.rows < 1 || piece_ < 4) {
    throw std::invalid_argument("global search: expected pieces of four thinned columns or more");
  }
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
  if (features.cols() != feature_rows_) {
    throw std::invalid_argument("global search: expected as many rows as the filter gives");
  }
  const Thinned run = thin(features);
  const auto rows = static_cast<std::size_t>(options_.rows);
  runs_.push_back({first, memory_.size() / rows});
  memory_.insert(memory_.end(), run.begin(), run.end());
  for (std::size_t i = 0; i < run.size(); i += rows) {
    energy_.push_back(energy_.back() + product_sum(&run[i], &run[i], options_.rows));
  }
}

// Correlation of a piece of `columns` thinned columns with the memory, at each thinned column.
std::vector<float> GlobalSearch::correlations(const std::int16_t* piece, int columns) const {
  const int n = columns * options_.rows;
  const auto places = static_cast<std::ptrdiff_t>(energy_.size()) - 1 - columns;
  std::vector<float> result(energy_.size() - 1, 0.0F);
  const double own = product_sum(piece, piece, n);
  for (std::ptrdiff_t i = 0; i <= places; ++i) {
    const double energy = own * (energy_[i + columns] - energy_[i]);
    const std::int32_t sum = product_sum(piece, &memory_[i * options_.rows], n);
    result[i] = energy > 0.0 ? static_cast<float>(sum / std::sqrt(energy)) : 0.0F;
  }
  return result;
}

// Score for each thinned column under the query's centre: the mean correlation of the pieces, each
// at the best place within its slack.
std::vector<float> GlobalSearch::scores(const Thinned& query) const {
  const auto rows = static_cast<std::size_t>(options_.rows);
  const auto columns = static_cast<int>(query.size() / rows);
  const int pieces = columns / piece_;
  const auto total = static_cast<std::ptrdiff_t>(energy_.size()) - 1;
  std::vector<float> sum(static_cast<std::size_t>(total), 0.0F);
  for (int p = 0; p < pieces; ++p) {
    const std::vector<float> at = correlations(&query[p * piece_ * rows], piece_);
    // From the query's centre to the piece's first thinned column, in the order of the memory.
    const int offset = p * piece_ - pieces * piece_ / 2;
    const int slack = static_cast<int>(std::ceil(options_.slack * std::abs(offset + 0.5 * piece_)));
    for (std::ptrdiff_t i = 0; i < total; ++i) {
      const auto from = std::max<std::ptrdiff_t>(0, i + offset - slack);
      const auto to = std::min<std::ptrdiff_t>(total - 1, i + offset + slack);
      float best = -1.0F;
      for (auto k = from; k <= to; ++k) best = std::max(best, at[static_cast<std::size_t>(k)]);
      sum[static_cast<std::size_t>(i)] += best / static_cast<float>(pieces);
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

GlobalMatch GlobalSearch::find(const Columns& query, const SamePlace& same_place) const {
  GlobalMatch match;
  const Columns both[2] = {query, query.colwise().reverse()};
  std::vector<float> score[2];
  const auto pieces = query.rows() / options_.thinning / piece_;
  if (pieces < 2 || runs_.empty() || query.cols() != feature_rows_) return match;
  for (int d = 0; d < 2; ++d) score[d] = scores(thin(both[d]));

  double squares = 0.0, mean = 0.0, best = -1.0;
  std::size_t place = 0;
  const double n = 2.0 * static_cast<double>(score[0].size());
  for (int d = 0; d < 2; ++d) {
    for (std::size_t i = 0; i < score[d].size(); ++i) {
      mean += score[d][i] / n;
      squares += score[d][i] * score[d][i] / n;
      if (score[d][i] <= best) continue;
      best = score[d][i];
      place = i;
      match.mirrored = d == 1;
    }
  }
  const double chance = std::sqrt(std::max(1e-12, squares - mean * mean));
  match.valid = true;
  match.score = (best - mean) / chance;
  match.margin = (best - second(score, place, match.mirrored, same_place)) / chance;
  match.accepted = match.margin >= options_.min_margin;
  // `place` is the middle one of the thinned columns that the pieces cover, from the query's start.
  const Eigen::Index thinned_before = pieces * piece_ / 2;
  const auto before = static_cast<double>(thinned_before * options_.thinning);
  match.column = column_of(place) - before + 0.5 * static_cast<double>(query.rows() - 1);
  return match;
}

std::size_t GlobalSearch::bytes() const {
  return memory_.size() * sizeof(std::int16_t) + energy_.size() * sizeof(double) +
         runs_.size() * sizeof(Run);
}

}  // namespace gprodom::gpr
