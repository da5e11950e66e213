// What is known of the robot's motion in a gap of the wheel, beside the IMU: how much its speed
// changes within a second, as the wheel has shown before, and what the encoder has counted
// meanwhile, which it tells after the gap. docs/estimation.md, "Gaps of the wheel".
#pragma once

#include <deque>
#include <optional>

#include "estimation/graph/slip_model.h"
#include "estimation/state_input.h"
#include "motion/history/sensor_history.h"

namespace gprodom {

class WheelGap {
 public:
  // Completes the input of an interval that begins at `from`, whose wheel distances are set. Call
  // for each interval in turn. slip: of the wheel, as known now.
  void complete(StateInput& input, TimeNs from, const WheelHistory& wheel, const SlipModel& slip);

  // Mean speed (m/s, by the wheel) over the state interval that ends at `to`.
  void learn(double speed, TimeNs to);

  // Root mean square of the change of speed in a second, m/s; 0 if nothing has been learnt.
  double speed_change() const;

 private:
  void end_gap(TimeNs end, const WheelHistory& wheel, const SlipModel& slip);

  struct Speed {
    TimeNs to;
    double mps;
  };
  struct Count {
    TimeNs at;
    double distance_m;
  };
  std::deque<Speed> recent_;  // of the last second
  double square_ = 0.0, pairs_ = 0.0;
  std::optional<Count> before_;        // the gap that has not ended yet
  std::optional<CountedWay> counted_;  // the last one, until it is told
};

}  // namespace gprodom
