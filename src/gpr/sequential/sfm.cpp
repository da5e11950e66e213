#include "gpr/sequential/sfm.h"

#include <algorithm>
#include <cmath>

#include "base/require.h"

namespace gprodom::gpr {

namespace {

// floor(x), clamped to 0..greatest. It is clamped first, so that the cast, which rounds
// non-negative numbers down, replaces a call of floor().
int clamped_floor(double x, int greatest) {
  return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(greatest)));
}

}  // namespace

double pixel_value(double amplitude, double amplitude_scale) {
  if (!std::isfinite(amplitude) || amplitude <= 0.0) return 0.0;
  return std::min(kMaxPixel, kMaxPixel * amplitude / amplitude_scale);
}

int feature_level(double pixel) {
  return clamped_floor(kMaxFeatureLevel * pixel / kMaxPixel, kMaxFeatureLevel);
}

void build_sfm(const FeaturePoint* points, std::size_t count, const SfmGrid& grid,
               LevelMatrix& levels) {
  require(grid.rows > 0 && grid.columns > 0 && grid.depth_range > 0.0 && grid.length > 0.0 &&
              grid.amplitude_scale > 0.0,
          "build_sfm: rows, columns, depth_range, length and amplitude_scale must be positive");
  levels.setZero(grid.rows, grid.columns);
  for (std::size_t i = 0; i < count; ++i) {
    const FeaturePoint& point = points[i];
    if (!std::isfinite(point.depth) || !std::isfinite(point.position)) continue;
    std::int8_t& cell =
        levels(clamped_floor(point.depth * grid.rows / grid.depth_range, grid.rows - 1),
               clamped_floor(point.position * grid.columns / grid.length, grid.columns - 1));
    const int level = feature_level(pixel_value(point.amplitude, grid.amplitude_scale));
    cell = std::max(cell, static_cast<std::int8_t>(level));
  }
}

void AmplitudeScale::collect(double amplitude) {
  if (!value_ && std::isfinite(amplitude) && amplitude > 0.0) seen_.push_back(amplitude);
}

bool AmplitudeScale::fix() {
  if (value_ || seen_.empty()) return value_.has_value();
  const double last = static_cast<double>(seen_.size() - 1);
  const auto at = seen_.begin() + static_cast<std::ptrdiff_t>(std::floor(quantile_ * last));
  std::nth_element(seen_.begin(), at, seen_.end());
  value_ = *at;
  std::vector<double>().swap(seen_);
  return true;
}

void AmplitudeScale::reset() {
  seen_.clear();
  value_.reset();
}

}  // namespace gprodom::gpr
