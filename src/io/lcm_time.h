// utime (microseconds, in messages) and TimeNs (nanoseconds, inside).
#pragma once

#include <cstdint>
#include <limits>

#include "gprodom/types.h"

namespace gprodom {

constexpr bool utime_fits(std::int64_t utime) {
  return utime >= 0 && utime <= std::numeric_limits<std::int64_t>::max() / 1000;
}

constexpr TimeNs from_utime(std::int64_t utime) { return utime * 1000; }

// Rounded down, for times before 1970 too.
constexpr std::int64_t to_utime(TimeNs time) {
  return time >= 0 ? time / 1000 : -((-time + 999) / 1000);
}

}  // namespace gprodom
