// An encoder with coarse ticks: what it shows is up to a tick behind, and between two ticks it
// shows no motion at all. docs/estimation.md, "Factors" and "Standstill".
#pragma once

#include <vector>

#include "estimation/state_input.h"
#include "gprodom/types.h"

namespace gprodom {

class WheelTick {
 public:
  // resolution_m: of one tick; 0: fine.
  void set_resolution(double resolution_m);

  // m, one standard deviation of a reading, of which an increment has one of its own.
  double sigma_m() const { return sigma_m_; }
  // From one tick to the next, at a speed that counts as none.
  TimeNs longest() const { return longest_; }

  // Call for each state interval in turn. Whether the robot may have set off without a tick since:
  // it stood, and then its mean specific force differed by more than noise from that of gravity
  // and bias. Ticks that come sooner than a standstill is decided hide nothing. samples: of the
  // interval; accel_density: m/s^2/sqrt(Hz), at rest.
  bool hides_motion(const StateResult& newest, const std::vector<ImuSample>& samples,
                    double accel_density, TimeNs to);

 private:
  double sigma_m_ = 0.0;
  TimeNs longest_ = 0;
  TimeNs set_off_ = -1;  // end of the interval in which the robot set off last; -1: never
};

}  // namespace gprodom
