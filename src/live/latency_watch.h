// From a message's arrival to the publication of what it caused, by the wall clock. Never part of
// an estimate.
#pragma once

#include <chrono>
#include <deque>
#include <mutex>

#include "gprodom/duration_histogram.h"
#include "gprodom/types.h"

namespace gprodom {

// Any thread may call any function.
class LatencyWatch {
 public:
  // A message of data time `time` has come in. Out of order, it is not watched.
  void arrived(TimeNs time);

  // What the message of data time `time` caused is out. Older ones caused nothing, and are
  // forgotten.
  void published(TimeNs time);

  DurationHistogram latencies() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Arrival {
    TimeNs time;
    Clock::time_point at;
  };

  mutable std::mutex mutex_;
  std::deque<Arrival> waiting_;  // by time
  DurationHistogram latencies_;
};

}  // namespace gprodom
