#include "gpr/revisit/revisit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/median.h"
#include "base/require.h"
#include "gpr/kernels/add_multiple.h"
#include "gpr/revisit/matrix_product.h"
#include "gpr/revisit/row_sums.h"

namespace gprodom::gpr {
namespace {

constexpr int kShifts = 3;  // earlier, as it is, later
constexpr double kLargestRho = 0.9999;
constexpr double kRefined = 1.1;  // refine() may use scales up to this times those of the survey

// The columns delayed by `shift` rows (a fraction), interpolated by a windowed sinc of 8 rows.
Columns delay_rows(const Columns& columns, double shift) {
  constexpr int kReach = 4;
  const auto rows = columns.cols();
  Columns delayed = Columns::Zero(columns.rows(), rows);
  for (int k = -kReach; k <= kReach; ++k) {
    const double at = k - shift;
    if (std::abs(at) >= kReach) continue;
    const double sinc = std::abs(at) < 1e-9 ? 1.0 : std::sin(M_PI * at) / (M_PI * at);
    const auto weight = static_cast<float>(sinc * (0.5 + 0.5 * std::cos(M_PI * at / kReach)));
    const auto from = std::max<Eigen::Index>(0, k), n = rows - std::abs(k);
    for (Eigen::Index i = 0; i < columns.rows(); ++i) {
      add_multiple(weight, columns.row(i).data() + std::max(0, -k), n,
                   delayed.row(i).data() + from);
    }
  }
  return delayed;
}

// Logarithm of the likelihood ratio, per half independent sample, of "the same ground under an
// unknown gain and noise" against "other ground", for correlations rho.
Eigen::ArrayXd evidence(const Eigen::ArrayXd& rho) {
  return -(1.0 - rho.max(0.0).min(kLargestRho).square()).log();
}

// Energy of each column. A column with far more than the median is scaled down, in place: a glitch
// of the receiver, or one strong reflector, would decide by itself. Twice the usual amplitude is
// left as it is; chance alone rarely reaches that with the dozen rows of a block.
Eigen::ArrayXf limit_energy(Columns& columns) {
  constexpr float kMost = 4.0F;  // times the median
  Eigen::ArrayXf energy = columns.array().square().rowwise().sum();
  const float limit = kMost * median(std::vector<float>(energy.begin(), energy.end()));
  for (Eigen::Index i = 0; i < energy.size(); ++i) {
    if (!(energy[i] > limit)) continue;
    columns.row(i) *= std::sqrt(limit / energy[i]);
    energy[i] = limit;
  }
  return energy;
}

}  // namespace

PatchMatcher::PatchMatcher(const PatchFilter& filter, double spacing, RevisitOptions options)
    : options_(std::move(options)),
      spacing_(spacing),
      shift_rows_(options_.time_shift / (filter.centre_frequency() * filter.row_interval())),
      stride_(std::max(1, static_cast<int>(filter.short_sigma()))) {
  for (int b = 0; b <= options_.depth_blocks; ++b) {
    edges_.push_back(filter.rows() * b / options_.depth_blocks);
  }
}

void PatchMatcher::correlate(const Columns& memory, const Columns& query) {
  const auto count = (query.rows() + stride_ - 1) / stride_;
  Columns sparse(count, query.cols());
  for (Eigen::Index i = 0; i < count; ++i) sparse.row(i) = query.row(i * stride_);
  Columns shifted(kShifts * count, query.cols());
  shifted << delay_rows(sparse, -shift_rows_), sparse, delay_rows(sparse, shift_rows_);
  tables_.resize(options_.depth_blocks);
  query_energy_.resize(tables_.size());
  memory_energy_.resize(tables_.size());
  for (int b = 0; b < options_.depth_blocks; ++b) {
    const int from = edges_[b], n = edges_[b + 1] - edges_[b];
    Columns stored = memory.middleCols(from, n), block = shifted.middleCols(from, n);
    memory_energy_[b] = limit_energy(stored);
    query_energy_[b] = limit_energy(block);
    // The tables keep their width: another width each time would allocate (and clear) each time.
    if (tables_[b].rows() != block.rows() || tables_[b].cols() < memory.rows()) {
      tables_[b].resize(block.rows(), memory.rows());
    }
    multiply_by_rows(block, stored, tables_[b]);
  }
}

// Adds one block's share of the correlations along a path.
void PatchMatcher::add_block(int block, const std::vector<int>& begin, Curves& curves) const {
  constexpr float kTiny = std::numeric_limits<float>::min();
  const auto n = curves.shifted.size();
  const auto columns = static_cast<int>(begin.size()), halfway = columns / 2;
  using Halves = Eigen::Array<float, Eigen::Dynamic, 2>;  // of the query
  const auto add_up = [&](const float* table, Eigen::Index stride, Halves& sum) {
    sum_rows(table, stride, begin.data(), halfway, n, &sum(0, 0));
    sum_rows(table + halfway * stride, stride, &begin[halfway], columns - halfway, n, &sum(0, 1));
  };
  Halves energy(n, 2), sum(n, 2);
  add_up(memory_energy_[block].data(), 0, energy);
  const auto share = static_cast<float>(1.0 / options_.depth_blocks);
  const Columns& table = tables_[block];
  Eigen::ArrayXf rho, best;
  for (int s = 0; s < kShifts; ++s) {
    const auto own = query_energy_[block].segment(s * columns, columns);
    add_up(&table(s * columns, 0), table.cols(), sum);
    rho = share * (sum.col(0) + sum.col(1)) /
          ((energy.col(0) + energy.col(1)) * own.sum()).max(kTiny).sqrt();
    if (s == 0) best = rho;
    best = best.max(rho);
    if (s != kShifts / 2) continue;
    curves.correlation += rho.cast<double>();
    const float parts[2] = {own.head(halfway).sum(), own.tail(columns - halfway).sum()};
    for (int h = 0; h < 2; ++h) {
      curves.half[h] +=
          (share * sum.col(h) / (energy.col(h) * parts[h]).max(kTiny).sqrt()).cast<double>();
    }
  }
  curves.shifted += best.cast<double>();
}

// places: from the tables' first column on.
PatchSurvey::Curves PatchMatcher::follow(Places places, bool mirrored, double scale) const {
  const double half_column = query_centre_ - std::floor(query_centre_);
  const int direction = mirrored ? -1 : 1;
  std::vector<int> step(tables_[0].rows() /
                        kShifts);  // from a place to the memory column under column i
  for (int i = 0; i < static_cast<int>(step.size()); ++i) {
    const double along = direction * scale * (i * stride_ - query_centre_);
    step[i] = static_cast<int>(std::floor(half_column + along + 0.5));
  }
  const auto [lowest, highest] = std::minmax_element(step.begin(), step.end());
  Curves curves;
  curves.mirrored = mirrored;
  curves.scale = scale;
  curves.first = std::max(places.first, -*lowest);
  const int n =
      std::min(places.end, static_cast<int>(memory_energy_[0].size()) - *highest) - curves.first;
  const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(std::max(n, 0));
  curves.shifted = curves.correlation = curves.half[0] = curves.half[1] = zero;
  if (n > 0) {
    for (int& s : step) s += curves.first;  // now from the first place
    for (int b = 0; b < options_.depth_blocks; ++b) add_block(b, step, curves);
  }
  curves.evidence = evidence(curves.shifted) + evidence(curves.correlation);
  curves.first += from_;
  return curves;
}

std::vector<PatchSurvey::Curves> PatchMatcher::search(const SurveyRange& range, Places inside,
                                                      Places wide) const {
  std::vector<Curves> curves;
  for (const bool mirrored : {false, true}) {
    const bool is_second_only = range.mirrored && *range.mirrored != mirrored;
    for (std::size_t i = 0; i < range.scales.size(); ++i) {
      const bool is_wide = i == range.wide;
      if (is_second_only && !is_wide) continue;
      curves.push_back(follow(is_wide ? wide : inside, mirrored, range.scales[i]));
      curves.back().number = i;
      curves.back().wide = is_wide;
    }
  }
  return curves;
}

RevisitMatch PatchMatcher::match(const Columns& memory, const Columns& query, double expected,
                                 double bound) {
  const double middle = 0.5 * static_cast<double>(memory.rows() - 1);
  SurveyRange range;
  range.place = middle + expected / spacing_;
  range.bound_m = bound;
  range.surround_m = options_.surround_m;
  for (const double scale : options_.scales) {
    if (scale != 1.0) range.scales.push_back(scale);
  }
  RevisitMatch match = survey(memory, query, range).best();
  if (match.valid) match.offset_m -= middle * spacing_;
  return match;
}

PatchSurvey PatchMatcher::survey(const Columns& memory, const Columns& query,
                                 const SurveyRange& range) {
  require(memory.cols() == edges_.back() && query.cols() == edges_.back(),
          "patches: expected as many rows as the filter gives");
  query_centre_ = 0.5 * static_cast<double>(query.rows() - 1);
  const double half_column = query_centre_ - std::floor(query_centre_);
  const double place = range.place - half_column;
  const double gate = range.bound_m / spacing_, wide = gate + range.surround_m / spacing_;
  // The columns under the query at the outermost places: within the bound for all scales and for
  // refine(), beyond it for the wide scale.
  const double longest = *std::max_element(range.scales.begin(), range.scales.end());
  const double finer = gate + options_.lobe_m / spacing_ + kRefined * longest * query_centre_;
  const double reach = std::max(finer, wide + range.scales[range.wide] * query_centre_) + 2.0;
  from_ = static_cast<int>(std::max(0.0, std::floor(place - reach)));
  const auto to = static_cast<int>(
      std::min<double>(static_cast<double>(memory.rows()), std::ceil(place + reach)));
  const auto least = range.scales[range.wide] * static_cast<double>(query.rows());
  if (query.rows() < 4 || to - from_ < least) return {};

  correlate(memory.middleRows(from_, to - from_), query);
  const auto places = [&](double half_width) {
    return Places{static_cast<int>(std::ceil(place - half_width)) - from_,
                  static_cast<int>(std::floor(place + half_width)) + 1 - from_};
  };
  PatchSurvey survey;
  survey.curves_ = search(range, places(gate), places(wide));
  survey.scales_ = range.scales.size();
  survey.inside_first_ = place - gate;
  survey.inside_last_ = place + gate;
  survey.half_column_ = half_column;
  survey.spacing_ = spacing_;
  survey.lobe_m_ = options_.lobe_m;
  survey.min_score_ = options_.min_score;
  survey.min_half_ = options_.min_half;
  // Both directions cover the same places, except for rounding.
  int end = std::numeric_limits<int>::max();
  for (const Curves& c : survey.curves_) {
    if (!c.wide) continue;
    survey.first_ = std::max(survey.first_, c.first);
    end = std::min(end, c.first + c.size());
  }
  survey.size_ = std::max(0, end - survey.first_);
  return survey;
}

void PatchMatcher::refine(PatchSurvey& survey, double place, bool mirrored, double scale) const {
  const double lobe = options_.lobe_m / spacing_;
  const Places near{static_cast<int>(std::ceil(place - lobe)) - from_,
                    static_cast<int>(std::floor(place + lobe)) + 1 - from_};
  for (const double finer : options_.scales) {
    if (finer != 1.0) survey.curves_.push_back(follow(near, mirrored, finer * scale));
  }
}

}  // namespace gprodom::gpr
