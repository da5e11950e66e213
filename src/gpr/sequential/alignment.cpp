#include "gpr/sequential/alignment.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/require.h"
#include "gpr/kernels/dot_product.h"

namespace gprodom::gpr {

namespace {

constexpr double kNoDistance = std::numeric_limits<double>::quiet_NaN();
constexpr double kPlaceVarianceFloor = 0.01;  // columns^2, see locate_minimum

// Row-major levels to 16-bit columns, one after the other: the overlap of two shifted windows is
// then one contiguous run in each. Returns the number of filled cells.
int to_columns(const LevelMatrix& levels, std::vector<std::int16_t>& columns) {
  const auto rows = static_cast<std::size_t>(levels.rows());
  const auto count = static_cast<std::size_t>(levels.cols());
  columns.resize(rows * count);
  const std::int8_t* level = levels.data();
  int filled = 0;
  for (std::size_t r = 0; r < rows; ++r) {
    std::int16_t* cell = columns.data() + r;
    for (std::size_t c = 0; c < count; ++c, ++level, cell += rows) {
      *cell = *level;
      filled += *level > 0 ? 1 : 0;
    }
  }
  return filled;
}

// sum[c] = energy of columns 0..c-1.
template <typename T>
void sum_energy(const T* columns, int rows, int count, std::vector<double>& sum) {
  sum.assign(static_cast<std::size_t>(count) + 1, 0.0);
  for (int c = 0; c < count; ++c) {
    const T* column = columns + static_cast<std::ptrdiff_t>(c) * rows;
    sum[c + 1] = sum[c] + static_cast<double>(dot_product(column, column, rows));
  }
}

template <typename Window>
void check_sizes(const Window& a, const Window& b) {
  require(a.rows() == b.rows() && a.cols() == b.cols() && a.rows() >= 1 && a.cols() >= 3,
          "align: both windows must have the same size, at least one row and three columns");
}

}  // namespace

int shift_limit(int columns, const AlignmentOptions& options) {
  const int least_overlap = std::max(1, static_cast<int>(std::ceil(options.min_overlap * columns)));
  const int limit = std::max(0, columns - least_overlap);
  return options.max_shift > 0 ? std::min(limit, options.max_shift) : limit;
}

Alignment locate_minimum(const ShiftDistances& distances, double independent_cells,
                         MinimumShape shape) {
  Alignment result;
  double least = std::numeric_limits<double>::infinity();
  for (int size = 0; size <= distances.limit; ++size) {
    for (const int shift : {-size, size}) {
      if (!(distances.at(shift) < least)) continue;  // NaN is never less
      least = distances.at(shift);
      result.shift = shift;
    }
  }
  result.subcolumn = result.shift;
  if (!std::isfinite(least)) return result;
  result.distance = least;
  result.overlap = distances.columns - std::abs(result.shift);
  if (std::abs(result.shift) == distances.limit) return result;

  const double before = distances.at(result.shift - 1), after = distances.at(result.shift + 1);
  const double curvature = before - 2.0 * least + after;
  if (!(curvature > 0.0)) return result;  // flat, or a neighbour without energy
  const double width =
      shape == MinimumShape::kParabola ? curvature : std::max(before, after) - least;
  result.subcolumn += 0.5 * (before - after) / width;
  const double cells = independent_cells * result.overlap / distances.columns;
  result.variance = kPlaceVarianceFloor + 2.0 * std::max(0.0, least) / (cells * curvature);
  result.valid = true;
  return result;
}

template <typename T>
void Aligner::fill_distances(const T* a, const T* b, int rows, int columns) {
  sum_energy(a, rows, columns, energy_a_);
  sum_energy(b, rows, columns, energy_b_);
  distances_.fill(columns, options_, [&](int width, int from_a, int from_b) {
    const double energy = (energy_a_[from_a + width] - energy_a_[from_a]) *
                          (energy_b_[from_b + width] - energy_b_[from_b]);
    if (!(energy > 0.0)) return kNoDistance;
    const auto product = dot_product(a + static_cast<std::ptrdiff_t>(from_a) * rows,
                                     b + static_cast<std::ptrdiff_t>(from_b) * rows,
                                     static_cast<std::size_t>(width) * rows);
    const double scale = options_.form == DistanceForm::kCosine ? std::sqrt(energy) : energy;
    return 1.0 - static_cast<double>(product) / scale;
  });
}

Alignment Aligner::align(const LevelMatrix& a, const LevelMatrix& b) {
  check_sizes(a, b);
  const int filled = to_columns(a, columns_a_) + to_columns(b, columns_b_);
  fill_distances(columns_a_.data(), columns_b_.data(), static_cast<int>(a.rows()),
                 static_cast<int>(a.cols()));
  // Only filled cells carry information on the place.
  return locate_minimum(distances_, std::max(1.0, 0.5 * filled), MinimumShape::kLines);
}

Alignment Aligner::align(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  check_sizes(a, b);
  fill_distances(a.data(), b.data(), static_cast<int>(a.rows()), static_cast<int>(a.cols()));
  // Samples of a band-limited trace, and neighbouring traces, are correlated: about every fourth is
  // independent.
  return locate_minimum(distances_, static_cast<double>(a.size()) / 4.0, MinimumShape::kParabola);
}

}  // namespace gprodom::gpr
