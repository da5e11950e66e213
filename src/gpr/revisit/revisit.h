// Matching for revisits (loop closures): where on stored ground a patch of newer ground lies, and
// with which variance.
//
// The correlation of every query column with every memory column near the expected place is
// computed once, for each block of depth and for small shifts in time. A direction, a scale along
// the track and an offset then define a path through these tables, and its entries are added up.
// docs/revisit.md derives the evidence and the variance.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "gpr/revisit/patch_filter.h"

namespace gprodom::gpr {

struct RevisitMatch {
  bool valid = false;        // false: the memory does not cover the query near `expected`
  double offset_m = 0.0;     // query centre minus memory centre along the memory's direction
  double sigma_m = 0.0;      // standard deviation of offset_m, if the match is right
  bool mirrored = false;     // the query was driven against the memory's direction
  double scale = 1.0;        // metres of memory per metre of query
  double score = 0.0;        // evidence of the best place less that of the second best
  double correlation = 0.0;  // at the best place, without shifts in time
  double half_sigmas = 0.0;  // correlation of the weaker half of the patch over that of chance
  bool accepted =
      false;  // score at or above RevisitOptions::min_score, and the checks below passed
};

struct RevisitOptions {
  // Metres of memory per metre of query. match() tries these; refine() tries these times the
  // survey's.
  std::vector<double> scales = {0.97, 0.985, 1.0, 1.015, 1.03};
  int depth_blocks = 4;      // each is normalised by itself, so that no depth dominates
  double time_shift = 0.25;  // periods of the centre frequency, for reflectors that dip sideways
  double lobe_m = 0.2;       // the second place is at least so far from the best one
  double surround_m = 1.0;   // the second place is searched so far beyond the bound
  double min_score = 0.1;    // least score of an accepted match
  double min_half = 2.0;     // gate: least correlation of each half of the patch, in standard
                             // deviations of chance (0: no gate)
};

// Where a survey looks. Lengths are along the memory.
struct SurveyRange {
  double place = 0.0;                // column of the memory where the query's centre is expected
  double bound_m = 0.0;              // the query lies within so much of `place`
  double surround_m = 0.0;           // the second place is searched so far beyond the bound
  std::vector<double> scales = {1};  // metres of memory per metre of query
  std::size_t wide = 0;              // number of the scale that is used beyond the bound too
  // The direction of the query against that of the memory, if known. The other direction is then
  // compared at the scale `wide` only, to find the second place.
  std::optional<bool> mirrored;
};

// The evidence of every place near the expected one, for both directions and all scales. A place is
// a column of the memory: the one under the query's centre (half a column before it, if the query
// has an even number of columns).
class PatchSurvey {
 public:
  bool empty() const { return size_ == 0; }

  // The places compared at the wide scale: the bound and its surroundings.
  int first() const { return first_; }
  int size() const { return size_; }

  // (size(), scales), for one direction: log likelihood ratio in nats of "the query's ground is
  // that of this place, at this scale" against "the query's ground is not in the memory".
  Eigen::ArrayXXd log_likelihood(bool mirrored) const;

  // The best place inside the bound; not valid where nothing was compared.
  RevisitMatch best() const;

  // The best within lobe_m of a place, for one direction. offset_m is from `place` 0.
  RevisitMatch around(double place, bool mirrored) const;

 private:
  friend class PatchMatcher;
  struct Curves {
    bool mirrored = false;
    double scale = 1.0;
    std::optional<std::size_t> number;  // of the scale in the range; none: added by refine()
    bool wide = false;
    int first = 0;               // the place of entry 0
    Eigen::ArrayXd shifted;      // correlation, mean over the blocks at each one's best time shift
    Eigen::ArrayXd correlation;  // the same without shift in time
    Eigen::ArrayXd half[2];      // the same of the query's first and second half
    Eigen::ArrayXd evidence;     // of the first two together

    int size() const { return static_cast<int>(evidence.size()); }
  };
  struct Peak {
    const Curves* curves = nullptr;
    int entry = 0;
    double evidence = -1.0;
    int place() const { return curves->first + entry; }
  };

  Peak highest(double from, double to, const bool* mirrored) const;
  double chance(const Peak& peak) const;
  RevisitMatch judge(const Peak& peak) const;
  bool beside(const Curves& curves, int entry, const Peak& peak) const;
  double evidence_by_chance() const;

  std::vector<Curves> curves_;
  std::size_t scales_ = 0;
  int first_ = 0, size_ = 0;
  double inside_first_ = 0.0, inside_last_ = 0.0;  // places within the bound
  double half_column_ = 0.0;                       // from a place to the query's centre
  double spacing_ = 0.0, lobe_m_ = 0.0, min_score_ = 0.0, min_half_ = 0.0;
};

class PatchMatcher {
 public:
  // Both patches are features of `filter`, `spacing` m apart.
  PatchMatcher(const PatchFilter& filter, double spacing, RevisitOptions options = {});

  // memory (columns, rows), query (columns, rows). The query's centre is expected at `expected` m
  // from the memory's centre, give or take `bound` m. Only places where the memory covers the
  // whole query are compared. Throws std::invalid_argument where the rows are not the filter's.
  RevisitMatch match(const Columns& memory, const Columns& query, double expected, double bound);

  // The same with the evidence of every place.
  PatchSurvey survey(const Columns& memory, const Columns& query, const SurveyRange& range);

  // Compares scales near `scale` as well, at places within lobe_m of `place`. Only for the survey
  // that this matcher made last.
  void refine(PatchSurvey& survey, double place, bool mirrored, double scale) const;

  double spacing() const { return spacing_; }
  const RevisitOptions& options() const { return options_; }

 private:
  using Curves = PatchSurvey::Curves;
  struct Places {
    int first = 0, end = 0;
  };

  void correlate(const Columns& memory, const Columns& query);
  Curves follow(Places places, bool mirrored, double scale) const;
  void add_block(int block, const std::vector<int>& begin, Curves& curves) const;
  std::vector<Curves> search(const SurveyRange& range, Places inside, Places wide) const;

  RevisitOptions options_;
  double spacing_;
  double shift_rows_;
  int stride_;              // query columns compared are this many apart
  std::vector<int> edges_;  // of the depth blocks, rows
  // Of the last survey:
  double query_centre_ = 0.0;    // columns
  int from_ = 0;                 // the memory's column that is the tables' first
  std::vector<Columns> tables_;  // [block] (shift, then query column; memory column and more)
  std::vector<Eigen::ArrayXf> query_energy_;   // [block], per row of the table
  std::vector<Eigen::ArrayXf> memory_energy_;  // [block], per memory column
};

}  // namespace gprodom::gpr
