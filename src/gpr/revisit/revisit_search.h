// Where on remembered ground the robot is, carried along the track: one patch of ground that
// repeats (rebar at an even pitch) fits at many places, and which of them it is shows only as the
// robot drives on. A discrete Bayes filter over the memory's columns, both directions of driving,
// and "nowhere": each new patch multiplies in its likelihood, the distance driven moves the belief
// along. docs/revisit.md, "Along the track".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "gpr/revisit/revisit.h"

namespace gprodom::gpr {

struct RevisitSearchOptions {
  RevisitOptions matcher;
  double patch_m = 1.84;     // of ground in a query
  double nowhere = 0.5;      // prior of not being on the memory at all
  double lost = 1e-4;        // share of the belief that starts anew with each patch
  double drift = 0.02;       // metres per metre by which odometry then and now may differ, at least
  double max_stretch = 0.5;  // ln; beyond, a patch has little over half its ground in common
  double certainty = 0.999;  // of one place over all others and nowhere, from which it is taken
  double min_half = 1.0;     // each half of the newest patch must correlate by that many standard
                             // deviations of chance, and no other place may fit it better
  int min_patches = 3;       // that must have agreed
  double agree_m = 0.05;     // between the patch found in the memory, and the memory found in the
                             // newer ground (0: not asked)
};

// A stretch of the memory on which the query may lie. Columns are numbered along the run from
// `first`, the number of the first one in `features`.
struct SearchWindow {
  std::size_t run = 0;    // the number of the run's first column: which run it is
  std::size_t first = 0;  // number of features.row(0)
  Columns features;       // the stretch expected with what surrounds it
  double expected = 0.0;  // number of the column at which the query's centre is expected
  double bound_m = 0.0;   // give or take, along the memory

  // ln of metres of memory per metre of query, its standard deviation, and that of its change since
  // the last query: 0 where the wheel did not slip then and does not now.
  double stretch = 0.0, stretch_sigma = 0.0, stretch_change = 0.0;
  std::optional<bool> mirrored;  // driven against the memory's direction, where that is known
};

struct PlaceFound {
  std::size_t window = 0;  // of those given
  double column = 0.0;     // number of the memory's column at the query's centre
  double certainty = 0.0;  // of the place against all others
  RevisitMatch match;      // offset_m counts from column 0
};

class RevisitSearch {
 public:
  RevisitSearch(const PatchFilter& filter, double spacing, RevisitSearchOptions options = {});

  int patch_columns() const { return patch_columns_; }
  // Ground that look() compares beyond a window's bound, and so wants in its features.
  double reach_m() const;

  // newest: (columns, rows), the newest ground in the order driven, at least patch_columns() of it;
  // the last patch_columns() are the query. moved_m: from the last query's centre to this one's,
  // driven on in the same run. Answers the places that are certain.
  std::vector<PlaceFound> look(const Columns& newest, double moved_m,
                               const std::vector<SearchWindow>& windows);

  // The run under way has ended: what was believed of it says nothing of the next.
  void forget() { beliefs_.clear(); }

 private:
  struct Belief {
    std::size_t run = 0;
    std::ptrdiff_t first = 0;   // number of the column of row 0
    int first_stretch = 0;      // of column 0, in steps of step_
    Eigen::ArrayXXd places[2];  // (place, stretch), as driven and mirrored
    double nowhere = 1.0;
    int patches = 0;
  };
  // Stretches that a query is compared at, first * step_ and so on, and how likely each is.
  struct Stretches {
    int first = 0;
    Eigen::ArrayXd share;
    int size() const { return static_cast<int>(share.size()); }
  };

  const Belief* last_on(const SearchWindow& window) const;
  Stretches anew(const SearchWindow& window) const;
  Stretches stretches(const SearchWindow& window, const Belief* before) const;
  Eigen::ArrayXd changes(const SearchWindow& window) const;
  Belief expect(const SearchWindow& window, const Belief* before, const PatchSurvey& survey,
                const Stretches& stretches, double moved_m) const;
  void move(const Belief& before, const SearchWindow& window, double moved_m, Belief& after) const;
  std::vector<PlaceFound> decide(const Belief& belief, PatchSurvey& survey,
                                 const SearchWindow& window) const;
  bool agrees_backwards(const Columns& newest, const SearchWindow& window, const PlaceFound& found);

  RevisitSearchOptions options_;
  PatchMatcher matcher_;
  int patch_columns_;
  double step_;  // from one stretch to the next
  std::vector<Belief> beliefs_;
};

}  // namespace gprodom::gpr
