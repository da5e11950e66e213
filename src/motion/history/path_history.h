// Distance along the robot's path over the last seconds.
#pragma once

#include <deque>

#include "base/by_time.h"
#include "gprodom/types.h"

namespace gprodom {

class PathHistory {
 public:
  bool empty() const { return places_.empty(); }
  TimeNs begin() const { return places_.front().time; }
  TimeNs end() const { return places_.back().time; }

  // Adds a step that ends at `time`, later than the last, at `speed` m/s (signed or unsigned).
  // Returns its metres; 0 for the first.
  double advance(TimeNs time, double speed) {
    const double moved = empty() ? 0.0 : speed * to_seconds(time - end());
    places_.push_back({time, (empty() ? 0.0 : places_.back().path_m) + moved});
    return moved;
  }

  void forget_before(TimeNs time) {
    while (!empty() && begin() < time) places_.pop_front();
  }

  // Metres, linear between places and constant beyond the ends. Only differences have a meaning.
  double path(TimeNs time) const { return interpolated(places_, time, &Place::path_m); }

 private:
  struct Place {
    TimeNs time;
    double path_m;
  };
  std::deque<Place> places_;
};

}  // namespace gprodom
