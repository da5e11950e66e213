// The wheel's slip as two antennas in a row show it. The window has their passages as measurements;
// here the slip is followed in between and since the last one, with the size of its wander.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "base/by_time.h"
#include "estimation/graph/slip_model.h"
#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "motion/history/sensor_history.h"

namespace gprodom {

class PairSlip {
 public:
  explicit PairSlip(const Config& config) : used_(config.gpr.antennas.size() > 1) {}

  // How far back the wheel's distance must be known: of a robot that is slow, or stops on the way.
  TimeNs memory() const { return used_ ? kMemory : 0; }

  // The distance of a passage is compared with the wheel's between its times.
  void add(const AntennaPassage& passage, const WheelHistory& wheel, double wheel_scale);

  // The passages up to a time, each handed out once: with the first state at or after its end.
  std::vector<AntennaPassage> take_passages(TimeNs to) { return take_ended(passages_, to); }

  // Whether a passage has ended so shortly before that the path is measured.
  bool knows(TimeNs time) const;
  // Standard deviation of l that passages leave at that time, of the last seconds: 0 where one has
  // measured the path, infinite where none tells of it. Nothing without antennas in a row.
  std::optional<double> left(TimeNs time) const;

  // The slips up to `to`, by the passages as far as they reach, otherwise unchanged. Where nothing
  // else follows the slip (none are given), intervals without a passage have none.
  std::vector<IntervalSlip> revise(std::vector<IntervalSlip> slips, TimeNs to);

 private:
  static constexpr TimeNs kMemory = 40'000'000'000;  // ns; longer than the window
  struct Seen {
    TimeNs middle;
    TimeNs lasted;
    double l, variance;  // ln(true distance / distance by the wheel)
  };
  Seen with_prior(const Seen& measured) const;
  std::optional<IntervalSlip> at(TimeNs time) const;
  bool used_;
  SlipModel model_;
  std::vector<AntennaPassage> passages_;  // not handed out yet
  std::deque<TimeNs> ends_;               // of the last intervals
  std::deque<Seen> seen_;                 // of the last seconds, newest last
  TimeNs known_until_ = 0;                // so far the last one's slip is taken to go on
};

}  // namespace gprodom
