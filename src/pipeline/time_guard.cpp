#include "pipeline/time_guard.h"

#include <algorithm>
#include <cstdlib>

namespace gprodom {

TimeGuard::TimeGuard(const TimeConfig& config)
    : reorder_(from_seconds(config.reorder_window)), max_jump_(from_seconds(config.max_jump)) {}

std::string TimeGuard::check(TimeNs time, TimeNs now) {
  if (time <= 0) return "stamp not after 1970";
  const bool ahead = now > 0 && time > now + max_jump_;
  const bool behind = now > 0 && time < now - max_jump_ - reorder_;
  if (ahead || behind) {
    const bool agrees = strays_ > 0 && time > stray_ && time < stray_ + max_jump_;
    strays_ = agrees ? strays_ + 1 : 1;
    stray_ = time;
    return ahead ? "stamp jumped ahead" : "stamp jumped back";
  }
  strays_ = 0;
  if (time < now - reorder_) return "later than time.reorder_window";
  if (time == newest_) return "stamp repeated";
  newest_ = std::max(newest_, time);
  return {};
}

void TimeGuard::reset() {
  newest_ = stray_ = 0;
  strays_ = 0;
}

}  // namespace gprodom
