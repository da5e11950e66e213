// The estimator: measurements in, poses out. Knows no LCM, no ROS and no clock.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/execution.h"
#include "gprodom/export.h"
#include "gprodom/front_end.h"
#include "gprodom/outputs.h"
#include "gprodom/types.h"

namespace gprodom {

class MapFrame;
class Pipeline;
class StateStore;
struct StartingPoint;
struct UserFactor;

// Not thread-safe: one thread calls it. Same sequence of calls, same output, to the byte
// (with kInline).
class GPRODOM_EXPORT Odometry {
 public:
  // Takes up what an earlier run has left in state.directory, and keeps it there: the wheel's
  // scale, the pair's track, the ground driven over, and the pose, which is gone on from where it
  // is state.resume_within old at most. front_end: a radar front end of your own
  // (gprodom/front_end.h) in place of gpr.front_end. Throws ConfigError where settings contradict
  // each other.
  explicit Odometry(const Config& config, Execution execution = Execution::kInline,
                    gpr::FrontEndFactory front_end = {});
  ~Odometry();
  Odometry(const Odometry&) = delete;
  Odometry& operator=(const Odometry&) = delete;

  // Bad samples (non-finite, out of range, out of time) are counted, warned of and dropped.
  void add(const ImuSample& sample);
  void add(const WheelSample& sample);
  void add(const WheelsSample& sample);  // once heard, a single wheel's samples are dropped
  void add(const GprTrace& trace);
  void add(const Displacement& external);

  // A measurement of your own (gprodom/user_factor.h), from the first moment in the window of
  // smoother.lag on. Returns why it is refused; empty: it is not. What is refused later, since the
  // window began afresh in the meantime, is told by a warning of a step() and counted in the
  // status.
  std::string add_factor(const UserFactor& factor);

  // Counts a message that could not be decoded, so that health tells of it.
  void reject(const std::string& channel, const std::string& reason);

  // Estimates as far as the data added so far allow.
  Outputs step();

  // With Execution::kThreaded: the worker threads take up what step() has found for them to do,
  // once its outputs are out. Without it they do so with the next step().
  void start_jobs();

  // End of data: what still waits for its reorder window is worked off.
  Outputs finish();

  // Keeps all states, so that smoothed() can solve over the whole run. Memory grows with the run;
  // call it before the first add().
  void record();

  // Every state as the fixed-lag window last held it: time and pose, the other fields are empty.
  // Throws std::runtime_error where nothing was recorded.
  std::vector<OdometryEstimate> recorded() const;

  // After finish(): time and pose in `map` of every state from one solution over all data since the
  // start, revisits among them; the other fields are empty. Throws std::runtime_error where there
  // is nothing recorded, or no solution.
  std::vector<OdometryEstimate> smoothed() const;

  Timing timing() const;

  // Starts at the initialiser, with the configuration and the ground driven over so far: where that
  // is found again, `map` becomes its frame.
  void reset();

  // The same without the ground.
  void forget();

  // The ground driven over, with where it lies, as a file. Waits until it is written. Throws
  // FileError; so do the next two where there is no map (gpr.enabled or graph.enabled is false),
  // and this and the next where state.map is read_only.
  void save_map(const std::string& path);

  // The same in the background; a warning of a later step() tells how it ended.
  void begin_saving_map(const std::string& path);

  // From here on looks for the ground of a saved map, in place of what was driven over so far;
  // where it is found, `map` becomes its frame. `odom` goes on. Throws FileError, and then nothing
  // has changed.
  void load_map(const std::string& path);

  // The robot is now about there in the map of earlier ground: that ground is searched first. A
  // revisit must prove it before the pose in map changes; a track that is located already is not
  // moved. Throws FileError where there is no map, std::invalid_argument where a figure is not
  // finite or the sigma is beyond the reach of that search.
  void locate_at(const RoughPlace& place);

 private:
  void start_afresh(StartingPoint start);
  void save_state();
  void begin_saving(const std::string& path);
  void expect_map(const std::string& path) const;
  void expect_writable(const std::string& path) const;
  void keep(Outputs& out);

  std::unique_ptr<StateStore> store_;  // outlives the map's jobs, which write through it
  std::vector<std::string> notices_;   // to go out with the next step
  Config config_;
  Execution execution_;
  gpr::FrontEndFactory front_end_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<MapFrame> map_frame_;
  OdometryEstimate newest_;
  OdometryEstimate here_;  // the newest of this track; the origin before its first
};

}  // namespace gprodom
