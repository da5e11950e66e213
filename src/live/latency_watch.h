// Measures the latency from a message's arrival to the publication of its result, by the wall
// clock. It never enters an estimate.
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
  // A message of data time `time` has arrived. One out of order is ignored.
  void arrived(TimeNs time);

  // The result of the message of data time `time` has been published. Older messages that still
  // wait had no result and are dropped.
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
