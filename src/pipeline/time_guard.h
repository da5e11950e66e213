// Which stamps of a sensor can be used. One guard per sensor; all share the IMU's clock.
#pragma once

#include <string>

#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

class TimeGuard {
 public:
  explicit TimeGuard(const TimeConfig& config);

  // now: the newest stamp accepted from any sensor, 0 before the first.
  // Empty where `time` is usable, else the reason to drop it.
  std::string check(TimeNs time, TimeNs now);

  // True once many messages in a row agreed on a time out of reach of `now`: the clock was set, and
  // the estimator must start afresh.
  bool moved() const { return strays_ >= kStraysToMove; }

  void reset();

 private:
  static constexpr int kStraysToMove = 50;
  TimeNs reorder_, max_jump_;
  TimeNs newest_ = 0;
  TimeNs stray_ = 0;  // newest of the stamps out of reach
  int strays_ = 0;
};

}  // namespace gprodom
