// Loop closure by a discrete Bayes filter along the track. One patch of ground that repeats (rebar
// at an even pitch) fits at many places; only as the robot drives on does it show which one it is.
// The filter's cells are the columns of the memory, each in both directions of driving, and
// "nowhere" for ground that is not in the memory. Each new patch multiplies in its likelihood, and
// the distance driven moves the belief along. Beside a place that is certain, little ground
// is compared. docs/revisit.md, "Along the track".
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
  double nowhere = 0.5;      // prior probability that the ground is not in the memory
  double lost = 1e-4;        // share of the belief that is spread evenly again with each patch
  double drift = 0.02;       // metres per metre: least difference of the odometry then and now
  double max_stretch = 0.5;  // ln; beyond it two patches share little more than half their ground
  double certainty = 0.999;  // least posterior probability of a place to be accepted
  double held_m = 0.6;       // how far from a certain place the next one is looked for
  double min_half = 1.0;   // gate on the newest patch: least correlation of each of its halves, in
                           // standard deviations of chance; and it must fit best at the place
  int min_patches = 3;     // least number of patches behind an accepted place
  bool clear_once = true;  // since a place is certain, a patch must have shown it by itself
  double agree_m = 0.05;   // gate on the search backwards, from the memory into the newer ground:
                           // how far its place may differ (0: no such search)
};

// A stretch of the memory on which the query may lie. Columns are numbered along the run from
// `first`, the number of the first one in `features`.
struct SearchWindow {
  std::size_t run = 0;    // the number of the run's first column: which run it is
  std::size_t first = 0;  // number of features.row(0)
  Columns features;       // the stretch expected with what surrounds it
  double expected = 0.0;  // number of the column at which the query's centre is expected
  double bound_m = 0.0;   // the place lies within so much of it, along the memory

  // Stretch: ln of metres of memory per metre of query, that is, the slip now less the slip then.
  // `grip`: probability that the wheel slips neither then nor now, so that it is 0; else its mean
  // and standard deviation. `kept`: probability that since the last query neither slip has begun or
  // ended; it has changed by so much then (standard deviation).
  double stretch = 0.0, stretch_sigma = 0.0, stretch_change = 0.0;
  double grip = 0.0, kept = 1.0;
  std::optional<bool> mirrored;  // driven against the memory's direction, where that is known
};

struct PlaceFound {
  std::size_t window = 0;  // of those given
  double column = 0.0;     // number of the memory's column at the query's centre
  double certainty = 0.0;  // posterior probability of the place
  RevisitMatch match;      // offset_m counts from column 0
};

class RevisitSearch {
 public:
  RevisitSearch(const PatchFilter& filter, double spacing, RevisitSearchOptions options = {});

  int patch_columns() const { return patch_columns_; }
  // A window's features must reach so far beyond its bound, since find() compares that ground too.
  double reach_m() const;

  // newest: (columns, rows), at least patch_columns() of the newest ground in the order driven; the
  // last patch_columns() of them are the query. moved_m: distance from the last query's centre to
  // this one's, in the same run. Returns the places that pass all gates.
  std::vector<PlaceFound> find(const Columns& newest, double moved_m,
                               const std::vector<SearchWindow>& windows);

  // The current run has ended. Its belief does not apply to the next run.
  void forget() { beliefs_.clear(); }

 private:
  struct Belief {
    std::size_t run = 0;
    std::optional<bool> mirrored;  // as of the window: the other direction has no share then
    std::ptrdiff_t first = 0;      // number of the column of row 0
    int first_stretch = 0;         // of column 0, in steps of step_
    Eigen::ArrayXXd places[2];     // (place, stretch), as driven and mirrored
    double nowhere = 1.0;
    int patches = 0;     // since the most probable place has been the same
    bool clear = false;  // since the place is certain, a patch has shown it by itself
  };
  // Before the newest patch counts. begun: the share of each place that the pass lies there from
  // this patch on, and was nowhere or elsewhere before.
  struct Prior {
    Belief belief;
    Eigen::ArrayXXd begun[2];
  };
  // The stretches at which a query is compared (first * step_, ...) and their probabilities.
  struct Stretches {
    int first = 0;
    Eigen::ArrayXd share;
    int size() const { return static_cast<int>(share.size()); }
  };

  // The most probable place: row and direction (1: mirrored), and the probability of its lobe.
  struct Peak {
    int direction = 0;
    Eigen::Index at = 0;
    double share = 0.0;
  };
  struct Held {
    double column = 0.0;  // number
    bool mirrored = false;
  };

  const Belief* last_belief_on(const SearchWindow& window) const;
  Peak peak_of(const Belief& belief) const;
  double lobe_share(const Eigen::ArrayXd& places, Eigen::Index at) const;
  std::optional<Held> held_place(const Belief* before, double moved_m) const;
  PatchSurvey survey_of(const Columns& query, const SearchWindow& window, const Belief* before,
                        const Stretches& asked, double moved_m);
  Stretches prior_stretches(const SearchWindow& window) const;
  Stretches stretches(const SearchWindow& window, const Belief* before) const;
  Eigen::ArrayXd stretch_transition(const SearchWindow& window) const;
  Prior expect(const SearchWindow& window, const Belief* before, const PatchSurvey& survey,
               const Stretches& stretches, double moved_m) const;
  void move(const Belief& before, const SearchWindow& window, double moved_m, Prior& after) const;
  Belief update(Prior prior, const PatchSurvey& survey, double moved_m) const;
  std::vector<PlaceFound> decide(Belief& belief, PatchSurvey& survey,
                                 const SearchWindow& window) const;
  bool agrees_backwards(const Columns& newest, const SearchWindow& window, const PlaceFound& found);

  RevisitSearchOptions options_;
  PatchMatcher matcher_;
  int patch_columns_;
  double step_;  // from one stretch to the next
  std::vector<Belief> beliefs_;
};

}  // namespace gprodom::gpr
