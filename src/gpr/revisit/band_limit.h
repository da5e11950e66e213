// What a map file keeps of traces: columns limited to the radar's band, over depth by fewer rows
// than samples and along the track by taking a running mean out. Neither gain nor spectrum is
// changed, so that features can be learnt anew, of one session or of several together.
// docs/map_format.md.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "gpr/revisit/patch_filter.h"

namespace gprodom::gpr {

struct BandLimit {
  static constexpr int kMostRows = 96;            // with 8 bytes of time 5.2 kB a metre
  static constexpr float kLevelsPerUnit = 31.0F;  // of a row's deviation: 4 of them fit a byte
  static constexpr float kLeast = 1e-15F, kGreatest = 1e15F;  // of a deviation

  std::size_t samples = 0;       // of a trace
  double sample_interval = 0.0;  // s
  int step = 1;                  // samples from one row to the next
  double low_cut = 0.0;          // Hz, half gain
  double long_sigma = 0.0;       // columns, of the running mean along the track
  // Standard deviation of each row along the track, in counts. It only says what a level is.
  Eigen::RowVectorXf deviation;

  int rows() const { return static_cast<int>(samples + step - 1) / step; }
  double row_interval() const { return step * sample_interval; }  // s

  // (rows(), samples): from a trace to a column, before the running mean is taken out.
  Columns projection() const;
  // Takes the running mean out.
  void high_pass_along(Columns& columns) const;
};

// Learns the limits from traces (columns, samples) and the filter that was learnt from them.
BandLimit learn_band_limit(const Columns& traces, double sample_interval,
                           const PatchFilter& filter);

// A filter from columns (n, rows) of the limits to features, learnt from them. row_step: rows from
// one feature to the next; 0: what the band needs. Throws std::invalid_argument as PatchFilter
// does.
PatchFilter learn_from_columns(const Columns& columns, const BandLimit& limit, double spacing,
                               PatchFilterOptions options, int row_step = 0);

// How traces of the same ground differ now from those that a filter was learnt from.
struct TraceChange {
  double stretch = 0.0;  // ln of travel times now over those then, counted from the direct wave
  double turn = 0.0;  // rad, by which the pulse's phase is ahead: another antenna, other coupling

  bool none() const { return stretch == 0.0 && turn == 0.0; }
};

// A filter for columns of ground that has changed: their features are those of the ground that
// `filter` was learnt from.
PatchFilter undoing(const TraceChange& change, const PatchFilter& filter, const BandLimit& limit);

// (rows, rows), times a column of features: each frequency turned by `angle` (rad) over depth.
Columns phase_turn(Eigen::Index rows, double angle);

// The same for traces: the limits first, then the filter.
PatchFilter for_traces(const PatchFilter& of_columns, const BandLimit& limit);

}  // namespace gprodom::gpr
