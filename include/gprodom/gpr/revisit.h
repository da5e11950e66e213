// Revisits: where on remembered ground a patch of newer ground lies, and how sure that is.
//
// The correlation of every query column with every memory column near the place expected is
// computed once, per block of depth and for small shifts in time; a direction, a scale along the
// track and an offset are then paths through these tables, along which is summed. See
// docs/revisit.md for the evidence and the variance.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "gprodom/gpr/patch_filter.h"

namespace gprodom::gpr {

struct RevisitMatch {
  bool valid = false;        // something was compared: the memory covers the query near `expected`
  double offset_m = 0.0;     // query centre minus memory centre along the memory's direction
  double sigma_m = 0.0;      // standard deviation of offset_m, if the match is right
  bool mirrored = false;     // the query was driven against the memory's direction
  double scale = 1.0;        // metres of memory per metre of query
  double score = 0.0;        // evidence of the best place less that of the second best
  double correlation = 0.0;  // at the best place, without shifts in time
  bool accepted =
      false;  // score at or above RevisitOptions::min_score, and the checks below passed
};

struct RevisitOptions {
  std::vector<double> scales = {0.97, 0.985, 1.0, 1.015, 1.03};
  int depth_blocks = 4;      // each correlated for itself, so that no depth drowns the others
  double time_shift = 0.25;  // periods of the centre frequency: reflectors that dip sideways
  double lobe_m = 0.2;       // what lies nearer to the best place is no second place
  double surround_m = 1.0;   // second places are sought this far beyond the bound
  double min_score = 0.1;    // accepted from here on
  double min_half = 2.0;     // each half of the patch must correlate by that many standard
                             // deviations of chance (0: not asked)
};

class PatchMatcher {
 public:
  // Both patches are features of `filter`, `spacing` m apart.
  PatchMatcher(const PatchFilter& filter, double spacing, RevisitOptions options = {});

  // memory (columns, rows), query (columns, rows). The query's centre is expected at `expected` m
  // from the memory's centre, give or take `bound` m. Only places where the memory covers the
  // whole query are compared. Throws std::invalid_argument where the rows are not the filter's.
  RevisitMatch match(const Columns& memory, const Columns& query, double expected, double bound);

 private:
  // Places are columns of `memory` below: first .. end - 1. The query's centre lies at a place plus
  // half a column where it has an even number of columns.
  struct Places {
    int first = 0, end = 0;
  };
  struct Curves;  // evidence and correlation over places, for one direction and scale
  struct Peak;    // the best place

  void correlate(const Columns& memory, const Columns& query);
  Curves follow(double query_centre, Places places, int direction, double scale) const;
  void add_block(int block, const std::vector<int>& step, Curves& curves) const;
  std::vector<Curves> search(double query_centre, Places inside, Places wide) const;
  RevisitMatch judge(const std::vector<Curves>& curves, const Peak& peak) const;

  RevisitOptions options_;
  double spacing_;
  double shift_rows_;
  int stride_;                                // query columns compared are this many apart
  std::vector<int> edges_;                    // of the depth blocks, rows
  std::vector<Columns> tables_;               // [block * 3 + shift] (query columns, memory columns)
  std::vector<Eigen::ArrayXf> query_energy_;  // [block * 3 + shift], per query column
  std::vector<Eigen::ArrayXf> memory_energy_;  // [block], per memory column
};

}  // namespace gprodom::gpr
