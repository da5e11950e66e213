#include "input/trigger_watch.h"

#include <cmath>

namespace gprodom {

void TriggerWatch::add_wheel(TimeNs time, double distance_m) {
  if (!last_m_) {
    last_m_ = rests_at_m_ = distance_m;
    rests_from_ = time;
    return;
  }
  const double step_m = std::abs(distance_m - *last_m_);
  last_m_ = distance_m;
  if (step_m > kLargestJump) {
    end_rest(time, distance_m);
    rested_without_ = false;
    return;
  }
  rolled_since_trace_m_ += step_m;
  if (std::abs(distance_m - rests_at_m_) > kRests_m) end_rest(time, distance_m);
  if (rested_without_ && is_due()) rested_without_ = false;  // it may have failed
}

void TriggerWatch::end_rest(TimeNs time, double distance_m) {
  const bool tells = time - rests_from_ > kShortestRest + 2 * kSettles;
  if (tells) rested_without_ = traces_at_rest_ <= 1;
  rests_at_m_ = distance_m;
  rests_from_ = time;
  traces_at_rest_ = 0;
}

// A trace of the last moment of braking, or of the first one of driving off before the wheel's next
// message, is none at rest.
void TriggerWatch::add_trace(TimeNs time) {
  rolled_since_trace_m_ = 0.0;
  if (!last_m_) return;
  if (rested_without_) found_ = Trigger::kDistance;
  rested_without_ = false;
  if (time - rests_from_ > kSettles && ++traces_at_rest_ >= kEnough) found_ = Trigger::kTime;
}

}  // namespace gprodom
