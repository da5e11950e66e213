// Where the work off the fast path is done, and how long it took.
#pragma once

#include <cstdint>

#include "gprodom/duration_histogram.h"

namespace gprodom {

// kInline does radar and solver work at once and always finishes it (replay, Python).
// kThreaded gives each a thread, and no pose waits for one. A radar result not ready at its data
// time is dropped; a late solve or correction of map counts as soon as it is there. All are counted
// in the status.
enum class Execution { kInline, kThreaded };

// Wall-clock time of work done off the fast path. Never part of an estimate.
struct WorkTime {
  std::int64_t jobs = 0;
  double total_s = 0.0;
  double longest_s = 0.0;
  DurationHistogram ready;  // from submission to result, the wait for the thread included
};

struct Timing {
  WorkTime solver;  // one job a state
  WorkTime radar;   // one job a tick
};

}  // namespace gprodom
