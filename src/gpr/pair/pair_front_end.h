// Displacement from two antennas in a row: for the newest ground under the trailing antenna, when
// was the leading one there? Between the two times the robot has moved by the distance of the
// antennas, whatever wheel and speed did. docs/pair.md has the principle.
//
// The match is done along the path as the estimator predicts it, in columns of equal spacing, so
// that stops and changes of speed do not matter, and what is left is an offset of centimetres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/pair_way.h"
#include "base/trace_format.h"
#include "gpr/filter/trace_quality.h"
#include "gpr/pair/alongside.h"
#include "gpr/pair/antenna_row.h"
#include "gpr/pair/columns.h"
#include "gpr/pair/match_scatter.h"
#include "gpr/pair/order_watch.h"
#include "gpr/pair/spectra.h"
#include "gpr/pair/transfer.h"
#include "gpr/pair/travel.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

struct Passage : AntennaPassage {
  double score = 0.0;  // of the match: evidence over the second-best place
  // In how many passages each part of the ground is: if they count as independent, the variance of
  // each is so many times as large.
  double overlap = 1.0;
};

enum class PairState {
  kWaits,      // too little ground driven over in one direction
  kLearns,     // the transfer between the antennas is not known yet
  kFollows,    // matches are found
  kNoMatch,    // the antennas do not see the same ground where they should
  kAmbiguous,  // the ground repeats itself
  kSwapped     // the rear antenna sees the ground first: cables or ids are exchanged
};

class PairFrontEnd {
 public:
  // When the passages begin that are still to come: the leading antenna was there, the trailing one
  // is not yet. Nothing where that is more than 10 s ago, as after a stop.
  static std::optional<TimeNs> begin_of_next(const GprConfig& config, const Travel& travel);

  PairFrontEnd(const GprConfig& config, const AntennaRow& row);

  // A trace of any antenna, in order of time for each of them. by_distance: traces come by the way,
  // so that a pause is a standstill; else it is a gap, across which nothing is compared.
  void add_trace(const GprTrace& trace, bool by_distance = false);

  // The passage of the ground driven over since the last one, if there is one; until it is known
  // that the antennas are in the configured order, none, and then those found before, too. In order
  // of time. travel: as predicted up to `tick`.
  std::vector<Passage> tick(TimeNs tick, const Travel& travel);

  void reset();

  PairState state() const { return state_; }

 private:
  struct Antenna : AntennaRow::Antenna {
    TraceCheck check = {};
    TraceFormat format = {};
    std::optional<Spectra> spectra = {};
    AntennaColumns columns = {};
    TimeNs newest = 0;
  };

  enum class Outcome { kNotCompared, kAside, kUnlike, kAmbiguous, kFound };

  // The comparison along one path.
  struct Match {
    Outcome outcome = Outcome::kNotCompared;
    bool forwards = true;
    Alongside found;             // in columns
    double predicted_m = 0.0;    // way from one passage to the other, by the path
    double scale = 1.0;          // true way over that one, at most 10
    TimeNs from = 0, to = 0;     // times of the passages
    ColumnMatrix query, memory;  // columns of the same places: what was seen
    bool compared() const { return outcome != Outcome::kNotCompared && outcome != Outcome::kAside; }
  };
  Match compare(const Run& run) const;
  bool is_aside(const Run& run, const Match& match, double begin, double end) const;
  // swapped: as antennas in the opposite order would see it.
  Match search(const Travel& travel, TimeNs tick, bool swapped = false) const;
  Match compare_in_order(const Run& run, const Travel& travel, TimeNs tick, bool believed);
  void refuse_swapped();
  std::vector<Passage> confirmed(TimeNs tick, const std::optional<Passage>& newest);
  static bool same_place(const Match& a, const Match& b);
  std::optional<Passage> accept(const Match& match, bool by_wheel);
  double spacing() const;  // m, from match to match
  bool transfer_known() const;
  bool is_believed(const Travel& travel) const;
  std::optional<Alongside> find(ColumnMatrix query, ColumnMatrix memory, Eigen::Index reach,
                                bool forwards) const;
  void learn(const ColumnMatrix& query, const ColumnMatrix& memory, bool forwards);

  GprFilterConfig band_;
  std::array<Antenna, 2> antennas_;  // front, rear
  double distance_m_;
  Transfer transfer_;
  OrderWatch order_;
  double unjudged_m_ = 0.0;    // driven since a patch was compared in both orders
  std::vector<Passage> held_;  // found before the order was confirmed
  PairState state_ = PairState::kWaits;
  int direction_ = 0;
  double next_s_ = 0.0;  // way to go until the next match, m
  double last_s_ = 0.0;  // of the path at the last tick
  TimeNs next_search_ = 0;
  int missed_ = 0;        // matches in a row
  MatchScatter scatter_;  // of matches along a wheel's path
};

}  // namespace gprodom::gpr
