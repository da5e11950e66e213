// The estimator: measurements in, poses out. Knows no LCM, no ROS and no clock.
#pragma once

#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/execution.h"
#include "gprodom/export.h"
#include "gprodom/front_end.h"
#include "gprodom/outputs.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"

namespace gprodom {

class MapFrame;
class Pipeline;
class StateStore;
struct GroundMap;
struct Rescue;
struct TraceFormat;
struct StartingPoint;
struct UserFactor;

// Not thread-safe: only one thread may call it. With kInline, the same sequence of calls gives
// byte-identical output.
class GPRODOM_EXPORT Odometry {
 public:
  // Loads the state of an earlier run from state.directory, and saves it there: the wheel's scale,
  // the calibration of left and right wheels, the ground driven over, and the pose. The pose is
  // resumed if it is at most state.resume_within old. front_end: a radar front end of your own
  // (gprodom/front_end.h) instead of gpr.front_end. Throws ConfigError if settings contradict each
  // other, FileError if another estimator uses state.directory (only with state.map read_only do
  // several share one).
  explicit Odometry(const Config& config, Execution execution = Execution::kInline,
                    gpr::FrontEndFactory front_end = {});
  ~Odometry();
  Odometry(const Odometry&) = delete;
  Odometry& operator=(const Odometry&) = delete;

  // Bad samples (not finite, out of range, with a wrong time) are counted and dropped with a
  // warning.
  void add(const ImuSample& sample);
  void add(const WheelSample& sample);
  void add(const WheelsSample& sample);  // from then on, samples of a single wheel are dropped
  void add(const GprTrace& trace);
  void add(const Displacement& external);
  void add(const PositionFix& fix);

  // A measurement of your own (gprodom/user_factor.h). Its moments must lie in the window of
  // smoother.lag. Returns the reason if it is refused, otherwise an empty string. If it is refused
  // later, because the window has been restarted since, a step() gives a warning, and the status
  // counts it.
  std::string add_factor(const UserFactor& factor);

  // Counts a message that could not be decoded. The status reports it.
  void reject(const std::string& channel, const std::string& reason);

  // Computes the estimates for the data added so far.
  Outputs step();

  // With Execution::kThreaded: starts the jobs of the worker threads. Call it after the outputs of
  // step() have been published. Otherwise the jobs start with the next step().
  void start_jobs();

  // End of data: processes the messages that still wait for the reorder window.
  Outputs finish();

  // Keeps all states, so that smoothed() can solve over the whole run. Memory grows with the run;
  // call it before the first add().
  void record();

  // Every state as it was when it left the fixed-lag window: time and pose; the other fields are
  // empty. Throws std::runtime_error if nothing was recorded.
  std::vector<OdometryEstimate> recorded() const;

  // After finish(): time and pose in `map` of every state, from one solution over all data since
  // the start, including revisits; the other fields are empty. Throws std::runtime_error if nothing
  // was recorded, or if there is no solution. antennas: of the fixes that it uses, by antenna_id.
  std::vector<OdometryEstimate> smoothed(std::map<int, FixAntenna>* antennas = nullptr) const;

  Timing timing() const;

  // Restarts at the initialiser. Keeps the configuration and the ground driven over so far. When
  // this ground is recognised, `map` becomes its frame.
  void reset();

  // After an exception (`failure`) from any function of this: restarts at the initialiser, with
  // what the run has learnt: ground, wheel scale, left and right wheels, slip. Where the map has
  // thrown three times within a minute of data, its ground is at fault: it is left out, and
  // ground.map of state.directory gets another name, which a warning of the next step tells. May
  // throw as well, in a front end's constructor, say; then it can be called again.
  void recover(const std::exception_ptr& failure);

  // The same without the ground. What is in ground.map of state.directory gets another name, which
  // a warning of the next step tells.
  void forget();

  // Saves the ground driven over, with its poses, to a file. Returns when it is written. A file
  // that holds ground which is not in this one, or that cannot be read, gets another name beside
  // it, which a warning of the next step tells. Throws FileError, also if no ground is stored yet
  // and the file holds some, and if there is no map (gpr.enabled or graph.enabled is false); this
  // holds for the next two as well. With state.map read_only, this and the next one throw.
  void save_map(const std::string& path);

  // The same in the background; a warning of a later step() reports the result.
  void begin_saving_map(const std::string& path);

  // Replaces the ground driven over so far by that of a saved map; what was driven over is saved in
  // state.directory before. When it is recognised, `map`
  // becomes its frame. `odom` continues. After a FileError nothing has changed.
  void load_map(const std::string& path);

  // The robot is now about there in the map of earlier ground: that ground is searched first. A
  // revisit must prove it before the pose in map changes; a track that is located already is not
  // moved. Throws FileError where there is no map, std::invalid_argument where a figure is not
  // finite or the sigma is beyond the reach of that search.
  void locate_at(const RoughPlace& place);

 private:
  void restart(StartingPoint start);
  Pipeline& ground_owner() const;  // that has the ground
  std::unique_ptr<Pipeline> make_pipeline(StartingPoint start);
  void set_pipeline(std::unique_ptr<Pipeline> pipeline);
  void advance_rerun(std::size_t most);
  std::optional<GroundMap> ground_of(const TraceFormat& format);
  std::optional<GroundMap> rescued_ground(bool of_map);
  void save_state();
  void begin_saving(const std::string& path, bool asked);
  void begin_saving_newest();
  bool save_ground();
  void set_ground_aside();
  void take_notices();
  void expect_map(const std::string& path) const;
  void expect_writable(const std::string& path) const;
  void save_due(Outputs& out);

  std::unique_ptr<StateStore> store_;  // outlives the map's jobs, which write through it
  std::vector<std::string> notices_;   // for the warnings of the next step
  Config config_;
  Execution execution_;
  gpr::FrontEndFactory front_end_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<Pipeline> rerun_;  // estimates the data so far again, and then takes over
  std::size_t rerun_messages_ = 0;   // messages, by that
  bool records_ = false;
  std::unique_ptr<MapFrame> map_frame_;
  std::unique_ptr<Rescue> rescue_;
  bool map_exchanged_ = false;  // in this step
  OdometryEstimate newest_;
  OdometryEstimate here_;  // the newest of this track; the origin before its first
};

}  // namespace gprodom
