// The estimator thread's side of the map: collects the input of the mapper's jobs, submits them at
// fixed data times, and makes the map -> odom correction from their answers.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/dated_worker.h"
#include "estimation/state_input.h"
#include "gprodom/config.h"
#include "gprodom/execution.h"
#include "map/mapper.h"

namespace gprodom {

// The map -> odom correction that puts the robot, which is at `now` in odom, where it is in map: at
// the settled pose, and from there on by the way since then. The settled state is some seconds old,
// and the graph's wheel scale and slip hold since then too.
Correction correction_by(const MapPose& settled, const OdometryEstimate& now);

// A job of the map has failed: its ground may be at fault, and may not be whole any more.
class MapFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class MapTask {
 public:
  // How odom lies in map, as Mapper has it.
  MapTask(const Config& config, Execution execution, std::optional<GroundMap> before = {},
          std::optional<TrackStart> start = {});
  // Waits for its jobs, so that a requested saving is not lost.
  ~MapTask() { drain(); }
  MapTask(const MapTask&) = delete;
  MapTask& operator=(const MapTask&) = delete;

  // If not, there is no correction: neither by ground nor by fixes.
  bool follows() const { return follows_; }

  // If not, no ground is stored, and there is none to save or to search.
  bool enabled() const { return enabled_; }

  // GroundMap::taken_from() of `before`.
  std::uint64_t taken_from() const { return taken_from_; }

  void add(const GprTrace& trace);
  // Of an antenna abreast of the one whose ground is stored, as that one would have measured it.
  void add_beside(const GprTrace& trace);
  void add(const Displacement& revisit);
  void add(const PositionFix& fix);
  // Adds a state in effect. Every half second a job is submitted.
  void add(const StateResult& result, TimeNs effective);

  // The robot is about there: the next job knows it.
  void locate_at(const ToldPlace& place) { next_.told = place; }

  // The next answer that is due and ready; never waits. Throws MapFailure where its job has thrown.
  // Its pose is kept for the next correct().
  std::optional<MapAnswer> next_due(TimeNs now);

  // Of a mapper that is slower than its input, since the last call: answers that are late, inputs
  // that were joined with later ones since both waited, and traces and revisits of other processes
  // that were dropped.
  struct Late {
    std::size_t answers = 0, joined = 0, dropped = 0;
  };
  Late take_late(TimeNs now);

  // The map -> odom correction by the last answer; nothing if there was none since the last call,
  // and odom has not jumped.
  std::optional<Correction> correct(const OdometryEstimate& estimate);

  // After the jobs so far, calls `take` on the worker's thread with the ground.
  // Only if enabled(). If the mapper is late, input that comes after this call may be in it.
  // main: to the file that save_newest() adds to.
  void save_ground(TimeNs now, bool main, std::function<void(SavedGround)> take);
  // The same with what is new since (Mapper::newest_ground()).
  void save_newest(TimeNs now, std::function<void(SavedGround)> take);

  void drain() { worker_.drain(); }
  void start_jobs() { worker_.start(); }
  WorkTime work_time() { return worker_.work_time(); }

  // Waits for all jobs and returns the ground. Taking it ends the mapper.
  GroundMap take_ground();
  GroundMap take_earlier_ground();
  SavedGround saved_ground();

  // Before the first state: keeps all revisits for revisits().
  void record() { mapper_.record(); }

  // Of the mapper. After drain(), with no job submitted since.
  std::vector<Revisit> revisits() const { return mapper_.track().revisits(); }
  // Empty where nothing could have deformed it.
  std::vector<TrackPiece> track() const {
    const TrackGraph& track = mapper_.track();
    return enabled_ || track.in_site() ? track.pieces() : std::vector<TrackPiece>();
  }
  std::vector<UsedFix> used_fixes() const { return mapper_.used_fixes(); }
  PlanarPose map_from_odom() const { return mapper_.track().map_from_odom(); }

 private:
  // What a job does: input for the mapper, then savings of the ground, the one of what is new last.
  struct Work {
    std::vector<MapInput> inputs;
    std::vector<std::function<void()>> savings;
    std::function<void()> newest;
  };
  template <class T>
  void keep(const T& item, std::vector<T>& waiting);
  void submit(TimeNs now, Work work);
  Work joined(Work earlier, Work later);
  MapAnswer run(const Work& work);

  const bool enabled_, follows_, uses_fixes_;
  const std::uint64_t taken_from_;
  const TimeNs latency_;
  MapInput next_;
  std::deque<GprTrace> traces_, beside_;  // newer than the newest settled state
  std::deque<PathState> unsettled_;  // states that are not settled, each as when it was the newest
  TimeNs last_submitted_ = 0;
  std::optional<MapPose> pose_;                    // of the last answer
  bool is_new_ = false, may_have_jumped_ = false;  // since the last correction: the answer; odom
  std::optional<Correction> corrected_;            // the last one
  std::optional<PathState> settled_;               // the newest
  std::deque<std::shared_ptr<Work>> submitted_;    // the jobs that have not begun, and perhaps more
  Late late_;

  // Used by the jobs of the worker alone, which no job outlives.
  Mapper mapper_;
  double travelled_m_ = 0.0,
         sigma_m_ = 0.0;  // of the last input; an answer to a saving has them too
  DatedWorker<MapAnswer> worker_;
};

}  // namespace gprodom
