// The subsurface feature matrix (SFM): radar peaks of a B-scan window, binned into a small matrix
// of feature levels, rows of depth by columns along the track (Li et al., arXiv 2503.18301).
//
// A peak at depth d in [0, D) and along-track position r in [0, L), of pixel amplitude m in [0,
// 255], puts level floor(10 m / 255) into the cell (floor(d D_S / D), floor(r L_S / L)). Indices
// count from 0; what lies outside is clamped into the border cells; of several peaks in one cell
// the largest level stays. Level 0 means that the cell has no feature.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gprodom/types.h"

namespace gprodom::gpr {

// Rows of depth (D_S) by columns along the track (L_S), oldest column first.
using LevelMatrix = Eigen::Matrix<std::int8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kMaxPixel = 255.0;

// A peak in the window: depth and position in the units of SfmGrid::depth_range and ::length,
// amplitude in the unit of SfmGrid::amplitude_scale.
struct FeaturePoint {
  double depth = 0.0;
  double position = 0.0;
  double amplitude = 0.0;
};

struct SfmGrid {
  int rows = 50;                 // D_S
  int columns = 50;              // L_S
  double depth_range = 1.0;      // D
  double length = 1.0;           // L
  double amplitude_scale = 1.0;  // the amplitude that is drawn as pixel value 255
};

// Pixel value min(255, 255 a / scale) of an amplitude; 0 for one that is not positive or not
// finite.
double pixel_value(double amplitude, double amplitude_scale);

// floor(10 m / 255), clamped to 0..10.
int feature_level(double pixel);

// Fills `levels` (grid.rows x grid.columns, resized if it is not) from `count` points in any order.
// Points that are not finite are left out. Throws std::invalid_argument on a grid that is not
// positive.
void build_sfm(const FeaturePoint* points, std::size_t count, const SfmGrid& grid,
               LevelMatrix& levels);

// The amplitude that is drawn as 255, fixed once for a run so that equal reflections get equal
// levels in every window. Collects amplitudes until told to stop and takes their quantile, which a
// few glitches do not move as they would the maximum.
class AmplitudeScale {
 public:
  explicit AmplitudeScale(double quantile = 0.99) : quantile_(quantile) {}

  void collect(double amplitude);

  // Ends the collection; false (and collecting goes on) when nothing positive was seen.
  bool fix();

  // Empty until fixed.
  std::optional<double> value() const { return value_; }

  void reset();

 private:
  double quantile_;
  std::vector<double> seen_;
  std::optional<double> value_;
};

}  // namespace gprodom::gpr
