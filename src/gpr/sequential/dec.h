// The dominant energy curve (DEC): the depth of the strongest reflector along a B-scan window, as
// one curve, and the alignment of two such curves. After Li, Guo, Song, "Subsurface feature-based
// ground robot/vehicle localization using a ground penetrating radar" (ICRA 2024), whose four steps
// are background segmentation, energy points, curve refinement, alignment of curves. Their details
// are not published; the functions below say what each step is here.
//
// Rows are trace samples, columns traces, oldest first.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "gpr/sequential/alignment.h"

namespace gprodom::gpr {

// A local maximum of a trace's energy that stands out of the background.
struct EnergyPoint {
  double row = 0.0;  // samples, with fraction
  double energy = 0.0;
};

constexpr int kMaxEnergyPoints = 4;

struct EnergyPoints {
  int count = 0;  // strongest first
  std::array<EnergyPoint, kMaxEnergyPoints> point;
};

// energy[i] = mean of trace[k]^2 over |k - i| <= half_width (fewer at the ends). `energy` has `n`
// elements and must not overlap `trace`.
void trace_energy(const float* trace, std::size_t n, int half_width, float* energy);

// Background segmentation: the energy that best parts a trace's samples into background and
// reflections (Otsu's threshold on the logarithm of energy). 0 where all is equal or zero.
double background_threshold(const float* energy, std::size_t n);

// The strongest local maxima at or above `threshold`, from `first_row` on, each at the vertex of
// the parabola through it and its neighbours.
EnergyPoints energy_points(const float* energy, std::size_t n, int first_row, double threshold);

struct CurveOptions {
  double jump_penalty = 0.01;  // lost score per squared sample of change from trace to trace
  int smoothing = 7;           // traces of the centred moving average; odd
};

// Curve refinement: of the points of each column one is chosen so that the sum of their energies
// (relative to the column's strongest) less the penalty on changes of row is greatest (dynamic
// programming); columns without points are interpolated; the result is smoothed.
class CurveRefiner {
 public:
  explicit CurveRefiner(const CurveOptions& options = {}) : options_(options) {}

  // `curve` gets one row (samples) per column. False where no column has a point; the curve is then
  // all zero. Allocates only where the number of columns grows.
  bool refine(const std::vector<EnergyPoints>& columns, Eigen::VectorXd& curve);

 private:
  void choose(const std::vector<EnergyPoints>& columns);
  void smooth(Eigen::VectorXd& curve);

  CurveOptions options_;
  std::vector<std::array<double, kMaxEnergyPoints>> score_;
  std::vector<std::array<int, kMaxEnergyPoints>> came_from_;
  std::vector<int> filled_;  // columns that have points
  Eigen::VectorXd rough_;
};

// Alignment of curves: for each shift (see alignment.h) the squared difference of the two curves
// over the common columns, relative to how much they vary there:
//   sum (a - b)^2 / (sum (a - mean a)^2 + sum (b - mean b)^2),
// NaN where both are flat. One value per column, a third of which are taken for independent.
class CurveAligner {
 public:
  explicit CurveAligner(const AlignmentOptions& options = {}) : options_(options) {}

  // Curves of equal length, at least 3. Throws std::invalid_argument otherwise.
  Alignment align(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

  const ShiftDistances& distances() const { return distances_; }

 private:
  AlignmentOptions options_;
  ShiftDistances distances_;
};

}  // namespace gprodom::gpr
