// Relocalisation: a place on kilometres of stored ground, without a prior, for a robot after a
// reset or on ground that was mapped before. The features of the memory (gpr/patch_filter.h) are
// thinned to a few numbers per decimetre, and the newest ground is correlated with all of it. It is
// compared in pieces, and each piece may lie a little off, because the wheels of the two passes
// stretch the ground differently.
// docs/revisit.md, "Anywhere".
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "gpr/revisit/patch_filter.h"

namespace gprodom::gpr {

struct GlobalSearchOptions {
  int thinning = 4;      // columns averaged into one
  int rows = 16;         // of depth, kept of a column's features
  double piece_m = 2.0;  // length of a piece, which is correlated as a whole
  double slack = 0.02;  // metres per metre of distance from the centre: how far a piece may lie off
  double distinct_m = 1.0;  // the second place is at least so far from the best one
  double min_margin = 2.0;  // gate: best score less the second, in standard deviations of chance
  std::vector<double> turns = {0.0, -0.8, 0.8};  // rad, of the pulse's phase, where they are tried
};

// The newest ground, (columns, rows) in the order driven.
struct GlobalQuery {
  Columns features;
  Columns quarter;  // the same with a phase that is ahead by a quarter undone; empty: no turn tried
};

struct GlobalMatch {
  bool valid = false;     // false: nothing could be compared
  double column = 0.0;    // of the memory at the query's centre, to the thinning
  bool mirrored = false;  // driven against the memory's direction
  std::size_t query = 0;  // which of the queries fits best there
  double turn = 0.0;      // and by which turn its phase is ahead
  double score = 0.0;     // correlation, standard deviations of chance
  double margin = 0.0;    // over the second best place
  bool accepted = false;  // margin at or above GlobalSearchOptions::min_margin
};

class GlobalSearch {
 public:
  // Of features of `filter`, `spacing` m apart. Throws std::invalid_argument on options that make
  // no sense.
  GlobalSearch(const PatchFilter& filter, double spacing, const GlobalSearchOptions& options = {});

  // A run of the memory: features (columns, rows), the first of number `first`. In the order of
  // the numbers.
  void add_run(std::size_t first, const Columns& features);

  // Whether two columns of the memory lie at the same place, which was then driven over twice.
  using SamePlace = std::function<bool(double, double)>;

  // queries: the same ground, as it would be without one change or another, of which one is right;
  // at least two pieces long (else the match is not valid). A column at the same place as the best
  // one is not the second place, whichever query fits there.
  GlobalMatch find(const std::vector<GlobalQuery>& queries, const SamePlace& same_place = {}) const;

  std::size_t bytes() const;

 private:
  // The numbers of a thinned column are contiguous, and so are those of a piece at any place.
  struct Run {
    std::size_t first = 0;  // number of its first column in the memory
    std::size_t begin = 0;  // of its thinned columns
  };
  using Thinned = std::vector<std::int16_t>;

  Thinned thin(const Columns& features) const;
  struct Turned {
    Thinned as_it_is, quarter;
  };
  // Over all queries, directions and turns.
  struct Survey {
    std::vector<float> highest[2];           // score of each thinned column, for each direction
    std::size_t first = 0, end = 0;          // where the memory covers the whole query, if anywhere
    double sum = 0, squares = 0, count = 0;  // of the scores there, which show what chance does
    double best = -1.0;
    std::size_t place = 0;  // of the best
  };
  void add(const GlobalQuery& query, std::size_t number, Survey& survey, GlobalMatch& match) const;
  std::vector<std::vector<float>> scores(const Turned& query) const;
  std::vector<std::vector<float>> correlations(const Turned& query, int piece) const;
  double column_of(std::size_t thinned) const;
  double second(const std::vector<float> (&score)[2], std::size_t best, bool mirrored,
                const SamePlace& same_place) const;

  GlobalSearchOptions options_;
  double spacing_;
  int feature_rows_;
  int piece_;  // thinned columns of a piece
  std::vector<Run> runs_;
  Thinned memory_;
  std::vector<double> energy_;  // of all thinned columns before this one
};

}  // namespace gprodom::gpr
