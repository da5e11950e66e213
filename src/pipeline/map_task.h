// The fast path's side of the map: collects what the mapper's jobs need, hands it to them at fixed
// data times, and makes the map -> odom correction of their answers.
#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "gprodom/state_estimator.h"
#include "pipeline/dated_worker.h"
#include "pipeline/mapper.h"

namespace gprodom {

class MapTask {
 public:
  MapTask(const Config& config, Execution execution);

  void add(const GprTrace& trace);
  void add(const Displacement& revisit);
  // A state in effect; every half second of them a job is submitted.
  void add(const StateResult& result, TimeNs effective);

  // The next answer whose time has come. A pose in it is kept for the next correct().
  std::optional<MapAnswer> next_due(TimeNs now);

  // The correction that brings the estimate to where the last answer has it; nothing where none
  // has come since the last call.
  std::optional<Correction> correct(const OdometryEstimate& estimate);

  WorkTime work_time() { return worker_.work_time(); }
  void drain() { worker_.drain(); }

  // Those that the map rests on. After drain(), with no job submitted since.
  std::vector<Revisit> revisits() const { return mapper_.revisits(); }

 private:
  void submit(TimeNs effective);

  const bool enabled_;
  const TimeNs latency_;
  MapInput next_;
  std::deque<GprTrace> traces_;      // newer than the newest settled state
  std::deque<PathState> unsettled_;  // as they were when they were the newest
  TimeNs last_submitted_ = 0;
  std::optional<MapPose> pose_;

  Mapper mapper_;  // used by the jobs of the worker alone, which no job outlives
  DatedWorker<MapAnswer> worker_;
};

}  // namespace gprodom
