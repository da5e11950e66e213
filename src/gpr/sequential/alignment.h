// The paper's constrained shift search: by how much one B-scan window (or a matrix or curve made of
// it) must be shifted along the track to match another. Adds a sub-column minimum, a variance from
// the minimum's shape, and a validity flag.
//
// The shift l is the place in B less the place in A: column c of A is found at column c + l of B,
// over w = L - |l| common columns. When traces enter on the right, content moves left: l < 0 as the
// robot goes on.
//
// Distance of two blocks (sums over the cells that both cover):
//   cosine   1 - sum(A B) / sqrt(sum(A^2) sum(B^2))
//   printed  1 - sum(A B) / (sum(A^2) sum(B^2)), as the paper prints it. It is not scale-free: the
//            fewer cells overlap, the smaller it gets, so its minimum runs to the search limit.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "gpr/sequential/sfm.h"
#include "gprodom/choices.h"

namespace gprodom::gpr {

struct AlignmentOptions {
  DistanceForm form = DistanceForm::kCosine;
  double min_overlap = 0.3;  // w_min / L
  int max_shift = 0;         // columns; 0: as far as min_overlap allows
};

struct Alignment {
  bool valid = false;      // a minimum inside the limits, curved upwards, energy on both sides
  int shift = 0;           // l*, columns
  double subcolumn = 0.0;  // l* with its fraction, columns
  double variance = 0.0;   // of subcolumn, columns^2; 0 where not valid
  double distance = 0.0;   // at l*
  int overlap = 0;         // common columns at l*
};

// The largest |l| searched for windows of `columns` columns.
int shift_limit(int columns, const AlignmentOptions& options);

// Distances for the shifts -limit..limit (element i is shift i - limit); NaN where one side has no
// energy in the overlap.
struct ShiftDistances {
  int limit = 0;
  int columns = 0;  // L of the matrices compared
  std::vector<double> distance;

  double at(int shift) const { return distance[static_cast<std::size_t>(shift + limit)]; }

  // Of two windows of so many columns. of(width, from_a, from_b): of the parts of `width` columns
  // that begin at column `from_a` of the one and `from_b` of the other.
  template <typename Of>
  void fill(int columns_of_each, const AlignmentOptions& options, Of of) {
    columns = columns_of_each;
    limit = shift_limit(columns, options);
    distance.clear();
    for (int shift = -limit; shift <= limit; ++shift)
      distance.push_back(of(columns - std::abs(shift), std::max(0, -shift), std::max(0, shift)));
  }
};

// Shape of the distance near its minimum, which gives the sub-column place: a parabola for smooth
// windows; two straight lines of equal slope for features that are binned into cells (a feature
// that moves by a fraction f of a column changes its cell with probability f).
enum class MinimumShape { kParabola, kLines };

// Finds the minimum of `distances` (the smallest |l| where several are equal), its sub-column place
// from it and its neighbours, and the variance of that place.
//
// Variance: for unit vectors a, b the squared residual is J(l) = |a - b(l)|^2 = 2 d(l). Least
// squares gives var = 2 s^2 / J'' with s^2 = J_min / n per independent cell, so with d ~ d_min +
// c/2 (l-l*)^2 var = 2 d_min / (n c). `independent_cells` is n, of a full overlap; it is scaled by
// w / L. The grid adds its own share: places finer than 1/10 column are not resolved (floor 0.01).
Alignment locate_minimum(const ShiftDistances& distances, double independent_cells,
                         MinimumShape shape);

// Keeps its buffers: no allocation from the second pair of one size on.
class Aligner {
 public:
  explicit Aligner(const AlignmentOptions& options = {}) : options_(options) {}

  // Both rows x columns, oldest column first, columns >= 3. Integer arithmetic throughout.
  // Throws std::invalid_argument where sizes differ.
  Alignment align(const LevelMatrix& a, const LevelMatrix& b);

  // The same for matrices of any values, such as the B-scan itself (samples x traces).
  Alignment align(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b);

  // Of the last pair.
  const ShiftDistances& distances() const { return distances_; }

 private:
  template <typename T>
  void fill_distances(const T* a, const T* b, int rows, int columns);

  AlignmentOptions options_;
  ShiftDistances distances_;
  std::vector<std::int16_t> columns_a_, columns_b_;  // levels, column after column
  std::vector<double> energy_a_, energy_b_;          // energy of the columns before each column
};

}  // namespace gprodom::gpr
