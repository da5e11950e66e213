#include "live/latency_watch.h"

namespace gprodom {
namespace {

constexpr std::size_t kMostWaiting = 20000;  // e.g. before the start, when nothing is published

}  // namespace

void LatencyWatch::arrived(TimeNs time) {
  const std::lock_guard lock(mutex_);
  // After the clock was set back, the order starts again.
  if (!waiting_.empty() && time <= waiting_.back().time - from_seconds(1.0)) waiting_.clear();
  if (!waiting_.empty() && time <= waiting_.back().time) return;
  if (waiting_.size() >= kMostWaiting) waiting_.pop_front();
  waiting_.push_back({time, Clock::now()});
}

void LatencyWatch::published(TimeNs time) {
  const std::lock_guard lock(mutex_);
  while (!waiting_.empty() && waiting_.front().time < time) waiting_.pop_front();
  if (waiting_.empty() || waiting_.front().time != time) return;
  latencies_.add(std::chrono::duration<double>(Clock::now() - waiting_.front().at).count());
  waiting_.pop_front();
}

DurationHistogram LatencyWatch::latencies() const {
  const std::lock_guard lock(mutex_);
  return latencies_;
}

}  // namespace gprodom
