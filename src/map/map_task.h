// The fast path's side of the map: collects what the mapper's jobs need, hands it to them at fixed
// data times, and makes the map -> odom correction of their answers.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/dated_worker.h"
#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "gprodom/execution.h"
#include "map/mapper.h"

namespace gprodom {

class MapTask {
 public:
  // As Mapper has it.
  MapTask(const Config& config, Execution execution, std::optional<GroundMap> before = {},
          std::optional<Mapper::Start> start = {});
  // Waits for its jobs: a saving that was asked for is not lost with the task.
  ~MapTask() { drain(); }
  MapTask(const MapTask&) = delete;
  MapTask& operator=(const MapTask&) = delete;

  // Where not, nothing is remembered, and there is no ground to save or to look for.
  bool enabled() const { return enabled_; }

  void add(const GprTrace& trace);
  void add(const Displacement& revisit);
  // A state in effect; every half second of them a job is submitted.
  void add(const StateResult& result, TimeNs effective);

  // The next answer whose time has come. A pose in it is kept for the next correct().
  std::optional<MapAnswer> next_due(TimeNs now);

  // The correction that brings the estimate to where the last answer has it; nothing where none
  // has come since the last call.
  std::optional<Correction> correct(const OdometryEstimate& estimate);

  // Hands the ground, once the jobs so far are done, as the bytes of a file to `take` (on the
  // worker's thread). Only where enabled().
  void save_ground(TimeNs now, std::function<void(std::string)> take);

  void drain() { worker_.drain(); }
  void start_jobs() { worker_.start(); }
  WorkTime work_time() { return worker_.work_time(); }

  // The ground, with all that was submitted so far: waits for it. Taking it ends the mapper.
  GroundMap take_ground();
  std::string ground_bytes();

  // Before the first state: keeps all revisits for revisits().
  void record() { mapper_.record(); }

  // Of the mapper. After drain(), with no job submitted since.
  std::vector<Revisit> revisits() const { return mapper_.revisits(); }
  std::vector<TrackPiece> track() const { return mapper_.track(); }
  PlanarPose map_from_odom() const { return mapper_.map_from_odom(); }

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
