// The estimator: measurements in, poses out. Knows no LCM, no ROS and no clock.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/duration_histogram.h"
#include "gprodom/types.h"

namespace gprodom {

// kInline does radar and solver work where it is due and always finishes it (replay, Python).
// kThreaded gives each a thread. A radar result not ready at its data time is dropped and counted;
// a solve is waited for, up to a limit, so that live equals replay on a busy machine too.
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
  WorkTime map;     // one job each half second
};

// What one step produced, each list in time order.
struct Outputs {
  std::vector<OdometryEstimate> odometry;         // one per accepted IMU sample, in `odom`
  std::vector<OdometryEstimate> odometry_in_map;  // the same, one for one, in `map`
  std::vector<Displacement> displacements;        // from the radar front end and the trace memory
  std::vector<Correction> corrections;  // map -> odom, twice a second from the first revisit on
  std::vector<SubsurfaceFeatureMatrix> sfm;  // when the front end makes them and is asked to
  std::vector<Status> status;                // once per second of data time
  std::vector<std::string> warnings;         // rate-limited, ready to be logged
  bool restarted = false;  // the clock was set: `odom` begins anew, at the initialiser
};

class MapFrame;
class Pipeline;
class StateStore;
struct Heritage;

// Not thread-safe: one thread calls it. Same sequence of calls, same output, to the byte
// (with kInline).
class Odometry {
 public:
  // Takes up what an earlier run has left in state.directory, and keeps it there: the wheel's
  // scale, the ground driven over, and the pose, which is gone on from where it is
  // state.resume_within old at most. Throws ConfigError where settings contradict each other.
  explicit Odometry(const Config& config, Execution execution = Execution::kInline);
  ~Odometry();
  Odometry(const Odometry&) = delete;
  Odometry& operator=(const Odometry&) = delete;

  // Bad samples (non-finite, out of range, out of time) are counted, warned of and dropped.
  void add(const ImuSample& sample);
  void add(const WheelSample& sample);
  void add(const GprTrace& trace);
  void add(const Displacement& external);

  // Counts a message that could not be decoded, so that health tells of it.
  void reject(const std::string& channel, const std::string& reason);

  // Estimates as far as the data added so far allow.
  Outputs step();

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
  // FileError.
  void save_map(const std::string& path);

  // The same in the background; a warning of a later step() tells how it ended.
  void begin_saving_map(const std::string& path);

  // From here on looks for the ground of a saved map, in place of what was driven over so far;
  // where it is found, `map` becomes its frame. `odom` goes on. Throws FileError, and then nothing
  // has changed.
  void load_map(const std::string& path);

 private:
  void start_afresh(Heritage heritage);
  void begin_saving(const std::string& path);
  void keep(Outputs& out);

  std::unique_ptr<StateStore> store_;  // outlives the map's jobs, which write through it
  std::vector<std::string> notices_;   // to go out with the next step
  Config config_;
  Execution execution_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<MapFrame> map_frame_;
  OdometryEstimate newest_;
};

}  // namespace gprodom
