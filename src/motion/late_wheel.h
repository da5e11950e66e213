// Pairs the distances of a late wheel with the IMU's data of the time when the wheel rolled them.
// docs/estimation.md, "A late wheel".
#pragma once

#include <deque>
#include <vector>

#include "estimation/state_input.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/history/sensor_history.h"

namespace gprodom {

class LateWheel {
 public:
  // Call for each interval in turn. true: what the intervals before have shown does not go on. The
  // delay in use follows the one that is learnt only where the robot stands: in motion, the state
  // to go on from is that of another time than the wheel's.
  bool follow(const StateInput& input);

  // The wheel is late, and the robot has not stood since that is known.
  bool waits() const { return waits_; }
  TimeNs delay() const { return delay_; }

  // `input` with the IMU's steps, and the standstill, of as much earlier as the wheel is late. Its
  // time stays that of the wheel's report. from: beginning of the interval.
  StateInput earlier(const StateInput& input, TimeNs from, const ImuHistory& imu,
                     const WheelHistory& wheel) const;

  // Keeps a path by the radar until the wheel has reported it.
  void keep(const gpr::PathLength& path);
  // The paths that are reported by now (the wheel's newest stamp), each once, oldest first.
  std::vector<gpr::PathLength> reported(TimeNs now);

 private:
  struct Interval {
    TimeNs to;
    bool standing;
  };
  bool stood(TimeNs since) const;

  bool waits_ = false;
  TimeNs delay_ = 0;
  std::deque<Interval> intervals_;  // as far back as the delay, newest last
  std::deque<gpr::PathLength> paths_;
};

// Sets slips to none that are not more than their standard deviation. The smoother pairs a late
// wheel with the accelerations of another time. A wheel that is less certain there gives way to
// them, which does more harm than a small slip.
void keep_shown(std::vector<IntervalSlip>& slips);

}  // namespace gprodom
