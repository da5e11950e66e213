// The ground driven over, stored by distance: a column of features (gpr/patch_filter.h) every 2 cm,
// one byte for each feature, and beside it the band-limited column that it was made of
// (gpr/band_limit.h), for a map file. The memory holds no poses: a caller that gets a patch gets
// each column's time and distance, and keeps the poses itself.
//
// Ground of one drive is a session. Each session has its band limits, and on loading its own
// filter; rows of all sessions are at the same travel times.
//
// Columns are numbered from 0 in the order driven and keep their numbers when the oldest are
// forgotten. A run is a stretch driven one way without a gap; a patch lies within one run.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "gpr/filter/glitch_check.h"
#include "gpr/revisit/band_limit.h"
#include "gpr/revisit/byte_columns.h"
#include "gpr/revisit/patch_filter.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

struct TraceMemoryOptions {
  double spacing_m = 0.02;
  double learn_m = 4.0;        // length of one run from which the filter is learnt; nothing is kept
                               // of the runs before it
  double max_length_m = 10e3;  // the oldest ground beyond is forgotten, a metre at a time
  double reversal_m = 0.05;    // so far back from the farthest point, the direction has changed
  double gap_m = 0.5;          // a longer gap between two traces ends the run
  double newest_m = 3.0;       // the longest patch that newest() can give
  double least_m = 3.0;        // new ground between known ground is kept from this length on
  PatchFilterOptions filter;
};

struct MemoryColumn {
  TimeNs time = 0;        // when the antenna was there
  double distance_m = 0;  // along the track, as given with the traces
  int direction = 1;      // -1: the distance fell with time
};

// Ground between two columns, first <= number < end.
struct MemoryRange {
  std::size_t first = 0, end = 0;
  std::size_t size() const { return end - first; }
};

// A run as a map file holds it.
struct StoredRun {
  std::size_t session = 0;
  int direction = 1;
  double first_distance_m = 0.0;
  std::vector<TimeNs> times;
  Levels levels;  // of band-limited columns
};

class TraceMemory {
 public:
  // Features have a standard deviation of 1 at most: 4 of them fit a byte.
  static constexpr float kLevelsPerUnit = 31.0F;

  explicit TraceMemory(TraceMemoryOptions options = {});

  // One trace, in time order, at `distance_m` along the track (signed: it falls when driving
  // back). It counts once the next one has come, unless it is a glitch of the receiver. Throws
  // std::invalid_argument on another number of samples than before; clear() first.
  void add(TimeNs time, const std::vector<float>& samples, double sample_interval,
           double distance_m);

  // A run from before: `features` (columns, rows) of `filter`, times of its columns and where the
  // first one lies. In the order driven; before any trace is added, and always with the same
  // filter. Throws std::invalid_argument where the sizes do not agree.
  void restore_run(const PatchFilter& filter, const std::vector<TimeNs>& times,
                   double first_distance_m, int direction, const Columns& features);

  // Runs from before as they were stored, in the order driven; before any trace is added. Filters
  // are learnt anew, for each session from its own ground if that is long enough. The newest
  // session's filter is that of traces to come. Throws std::invalid_argument where sessions differ
  // in the rows of their columns, or where the sizes do not agree.
  void restore(std::vector<BandLimit> sessions, const std::vector<StoredRun>& runs);
  StoredRun stored_run(MemoryRange range) const;  // of kept columns within one run
  std::size_t session_of(std::size_t number) const { return run_at(number)->session; }

  // Of the columns that are kept, and of those to come. Empty if nothing is learnt yet, and where
  // the ground was restored as features.
  const std::vector<BandLimit>& sessions() const { return sessions_; }
  // Ground to come is that of another drive, or of another antenna: a session from its first column
  // on.
  void begin_session() { begins_session_ = !sessions_.empty(); }
  // Ground to come, after end_run(), is of a session that has begun since the ground was restored.
  void resume_session(std::size_t session);

  // The ground of the current run between these two distances along the track is already stored
  // from an earlier pass. Columns there that are not stored yet are skipped. The run is then split
  // into pieces, each of which is a run of its own.
  void mark_known(double one_m, double other_m);

  // An empty memory with the same filter, for the newest ground of another antenna. Only where the
  // filter is known.
  TraceMemory beside() const;

  // Ends the run (after a gap in time, say).
  void end_run();
  // Forgets everything, the filter too.
  void clear() { *this = TraceMemory(options_); }

  // Empty until enough ground was seen.
  const std::optional<PatchFilter>& filter() const { return filter_; }
  const TraceMemoryOptions& options() const { return options_; }
  double spacing() const { return options_.spacing_m; }

  // The stored columns. The newest ground, some 1.5 m behind the antenna, is not yet among them,
  // because its band-pass needs the ground that follows.
  MemoryRange kept() const { return {first_, first_ + times_.size()}; }
  std::size_t bytes() const;

  // Time, distance and direction of a stored column. Throws std::out_of_range.
  MemoryColumn column(std::size_t number) const;
  // The last stored column with number `first` or higher that was driven over at `time` or before.
  // Times from `first` on must not decrease.
  std::optional<std::size_t> column_at(TimeNs time, std::size_t first = 0) const;
  // The kept part of the run that holds a kept column.
  MemoryRange run_of(std::size_t number) const;
  // Features (columns, rows) of kept columns, in the order driven. Throws std::out_of_range.
  Columns patch(MemoryRange range) const;
  // The same of columns within one run, as they would be without the change.
  Columns patch(MemoryRange range, const TraceChange& change) const;
  // Whether features can be made of band-limited columns again: of ground that was restored so.
  bool can_undo() const { return of_columns_.has_value(); }

  // The newest ground of the current run up to the antenna, in the order driven: `count` columns as
  // a query, up to `before` columns before them, and the query's middle column. Nothing if the run
  // is shorter than a query.
  // change: of this ground since the ground that was restored; only if can_undo().
  struct Newest {
    Columns features;
    MemoryColumn centre;
  };
  std::optional<Newest> newest(int count, int before = 0, const TraceChange& change = {}) const;
  // The middle column of such a query, without features.
  std::optional<MemoryColumn> newest_place(int count) const;

  // The newest ground driven one way, up to the antenna, whether it is stored yet or not: how many
  // columns of number `first` or higher, features of the last `count` of them in the order driven,
  // and the one that is so many before the last (at most newest_m). For ground too long for
  // newest().
  std::size_t newest_columns(std::size_t first) const;
  Columns newest_ground(std::size_t count, const TraceChange& change = {}) const;
  MemoryColumn newest_column(std::size_t before = 0) const;

 private:
  struct Sample {  // one or more traces at nearly one place, averaged
    TimeNs time = 0;
    double distance = 0.0;
    int count = 0;
    Eigen::RowVectorXf values;
  };
  struct Run {
    std::size_t first = 0;
    double distance = 0.0;  // of its first column
    int direction = 1;
    std::size_t session = 0;
  };
  // Those of sessions with enough ground; the others have the filter of the longest one. Sessions
  // that began since have that of the newest one restored.
  struct SessionFilters {
    PatchFilter longest;
    std::map<std::size_t, PatchFilter> own;
    std::size_t sessions = 0;  // restored
    const PatchFilter& of(std::size_t session) const {
      const auto found = own.find(std::min(session, sessions - 1));
      return found == own.end() ? longest : found->second;
    }
  };
  struct Pending {
    MemoryColumn place;
    Eigen::RowVectorXf features;  // until the filter is learnt the trace
    Eigen::RowVectorXf limited;   // band-limited
  };

  void take(Sample sample);
  void step_to(Sample next);
  void emit(const MemoryColumn& place, const Eigen::RowVectorXf& trace);
  void learn();
  void set_filter(const PatchFilter& filter);
  void keep_settled(bool all);
  bool is_known(const MemoryColumn& place) const;
  void end_piece();
  void end_run_before_waiting();
  void keep(const MemoryColumn& place, const Eigen::RowVectorXf& features);
  std::deque<Run>::const_iterator run_at(std::size_t number) const;
  SessionFilters learn_filters(const std::vector<StoredRun>& runs) const;
  void restore_columns(const StoredRun& run, const PatchFilter& filter);
  void forget_oldest();
  Columns filtered_pending() const;
  // Of the last `count` of them.
  Columns filtered_pending(Eigen::Index count, const TraceChange& change) const;
  Columns limited_pending() const;
  Columns features_of(const Columns& columns, std::size_t session, const TraceChange& change) const;

  TraceMemoryOptions options_;
  double sample_interval_ = 0.0;
  std::optional<PatchFilter> filter_;
  std::vector<BandLimit> sessions_;
  std::optional<SessionFilters> of_columns_;  // of the sessions restored: columns to features
  std::size_t session_ = 0;                   // of the ground to come, unless
  bool begins_session_ = false;               // one begins with the next column
  Columns to_limited_;  // of the newest session: traces to band-limited columns
  int context_ = 0;     // columns that the band-pass reaches to either side

  // A trace waits for the next one, which shows whether it is a glitch. It is compared with its
  // neighbours as raw samples until the filter is learnt, then as features.
  std::optional<Sample> waiting_;
  Eigen::RowVectorXf waiting_features_, features_before_;  // features_before_: of the last good one
  GlitchCheck glitches_;

  std::optional<Sample> last_;
  int direction_ = 0;  // of the run under way; 0: not known yet
  double next_ = 0.0;  // distance of its next column
  // The current run, oldest first: raw traces until the filter is learnt, then features before the
  // band-pass. The first settled_ of them are already stored and serve as context.
  std::deque<Pending> pending_;
  std::size_t settled_ = 0;
  bool run_kept_ = false;                         // a column of the current piece has been stored
  std::vector<std::pair<double, double>> known_;  // known stretches of the current run, m

  ByteColumns features_, limited_;  // no limited ones where there is no session
  std::deque<TimeNs> times_;
  std::deque<Run> runs_;
  std::size_t first_ = 0;
};

}  // namespace gprodom::gpr
