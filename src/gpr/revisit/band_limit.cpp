#include "gpr/revisit/band_limit.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {
namespace {

constexpr double kHeadroom = 0.8;    // of the features' row interval: another pulse may be shorter
constexpr double kLowCut = 0.2;      // of the centre frequency, below the cut of the features
constexpr double kHighCut = 0.9;     // of what the rows can hold, half gain
constexpr double kKernelRows = 4.0;  // the kernel reaches so many rows to either side

// Low-pass and thinning: a windowed sinc at every row.
Columns thinning(int rows, Eigen::Index samples, int step) {
  if (step == 1) return Columns::Identity(samples, samples);
  Columns matrix = Columns::Zero(rows, samples);
  const double reach = kKernelRows * step;
  for (int row = 0; row < rows; ++row) {
    for (Eigen::Index j = 0; j < samples; ++j) {
      const double lag = static_cast<double>(j) - static_cast<double>(row) * step;
      if (std::abs(lag) >= reach) continue;
      const double x = M_PI * kHighCut * lag / step;
      const double sinc = lag == 0.0 ? 1.0 : std::sin(x) / x;
      matrix(row, j) = static_cast<float>(sinc * (0.5 + 0.5 * std::cos(M_PI * lag / reach)));
    }
    matrix.row(row) *= static_cast<float>(kHighCut / step);
  }
  return matrix;
}

// The row at which the ground begins to change along the track: just behind the direct wave.
int first_row(const BandLimit& limit) {
  constexpr float kNotice = 0.1F;  // of the largest deviation
  const float least = kNotice * limit.deviation.maxCoeff();
  int row = 0;
  while (limit.deviation[row] < least) ++row;
  return row;
}

Columns high_pass(const Columns& columns, double sigma) {
  Columns slow = columns;
  smooth_along(sigma, slow);
  return columns - slow;
}

}  // namespace

// The low frequencies are taken out of the thinning's rows: a matrix of (samples, samples) might be
// large.
Columns BandLimit::projection() const {
  const Columns by_sample = thinning(rows(), static_cast<Eigen::Index>(samples), step).transpose();
  return high_pass(by_sample, gaussian_of(low_cut * sample_interval)).transpose();
}

void BandLimit::high_pass_along(Columns& columns) const {
  columns = high_pass(columns, long_sigma);
}

BandLimit learn_band_limit(const Columns& traces, double sample_interval,
                           const PatchFilter& filter) {
  BandLimit limit;
  limit.samples = static_cast<std::size_t>(traces.cols());
  limit.sample_interval = sample_interval;
  const int fewest =
      (static_cast<int>(traces.cols()) + BandLimit::kMostRows - 1) / BandLimit::kMostRows;
  limit.step =
      std::max({1, fewest, static_cast<int>(kHeadroom * filter.row_interval() / sample_interval)});
  limit.low_cut = kLowCut * filter.centre_frequency();
  limit.long_sigma = filter.long_sigma();
  Columns columns = traces * limit.projection().transpose();
  limit.high_pass_along(columns);
  limit.deviation = columns.colwise().squaredNorm() / static_cast<float>(columns.rows());
  limit.deviation = limit.deviation.cwiseSqrt();
  const float least = std::max(BandLimit::kLeast, 1e-6F * limit.deviation.maxCoeff());
  limit.deviation = limit.deviation.cwiseMax(least).cwiseMin(BandLimit::kGreatest).eval();
  return limit;
}

PatchFilter learn_from_columns(const Columns& columns, const BandLimit& limit, double spacing,
                               PatchFilterOptions options, int row_step) {
  options.taken_out = limit.long_sigma;
  options.row_step = row_step;
  return {columns, spacing, limit.row_interval(), options};
}

// A windowed Hilbert transform turns by a quarter. Its reach is that of the lowest frequency of the
// features, 0.3 of the centre, whose period has some 11 rows.
Columns phase_turn(Eigen::Index rows, double angle) {
  constexpr double kReach = 12.0;
  Columns turn = std::cos(angle) * Columns::Identity(rows, rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index j = row % 2 == 0 ? 1 : 0; j < rows; j += 2) {
      const auto lag = static_cast<double>(row - j);
      if (std::abs(lag) >= kReach) continue;
      const double quarter = 2.0 / (M_PI * lag) * (0.5 + 0.5 * std::cos(M_PI * lag / kReach));
      turn(row, j) = static_cast<float>(-std::sin(angle) * quarter);
    }
  }
  return turn;
}

// Rows are interpolated by a windowed sinc.
PatchFilter undoing(const TraceChange& change, const PatchFilter& filter, const BandLimit& limit) {
  LearntPatchFilter learnt = filter.learnt();
  const int rows = limit.rows();
  const double from = first_row(limit);
  Columns resample = Columns::Zero(rows, rows);
  for (int row = 0; row < rows; ++row) {
    const double at = from + (row - from) * std::exp(row < from ? 0.0 : change.stretch);
    for (int j = 0; j < rows; ++j) {
      const double lag = j - at;
      if (std::abs(lag) >= kKernelRows) continue;
      const double sinc = std::abs(lag) < 1e-9 ? 1.0 : std::sin(M_PI * lag) / (M_PI * lag);
      resample(row, j) =
          static_cast<float>(sinc * (0.5 + 0.5 * std::cos(M_PI * lag / kKernelRows)));
    }
  }
  learnt.projection = (learnt.projection * resample).eval();
  if (change.turn != 0.0)
    learnt.projection = (phase_turn(filter.rows(), -change.turn) * learnt.projection).eval();
  return PatchFilter(std::move(learnt));
}

PatchFilter for_traces(const PatchFilter& of_columns, const BandLimit& limit) {
  LearntPatchFilter learnt = of_columns.learnt();
  learnt.projection = (learnt.projection * limit.projection()).eval();
  return PatchFilter(std::move(learnt));
}

}  // namespace gprodom::gpr
