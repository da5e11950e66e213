// The estimator with its commands and notices, one input at a time. Shared by live and replay.
#pragma once

#include <exception>
#include <map>
#include <string>
#include <vector>

#include "gprodom/input.h"
#include "gprodom/odometry.h"

namespace gprodom {

// Whether there is nothing to hand out.
bool is_empty(const Outputs& outputs);

// Not thread-safe: one thread calls it.
class Runner {
 public:
  // Throws ConfigError where settings contradict each other.
  Runner(const Config& config, Execution execution, gpr::FrontEndFactory front_end = {});

  // Adds the input, or carries it out if it is a command, and steps.
  Outputs feed(const Input& input);

  // Steps without input, so that finished results of worker threads are returned.
  Outputs step();

  // Call it after the results have been handed out (Odometry::start_jobs()).
  void start_jobs() { odometry_.start_jobs(); }

  // End of data.
  Outputs finish();

  // Call it before the first feed(): keeps all states for smoothed().
  void record() { odometry_.record(); }

  // After finish(): every state in map from one solution over all data (Odometry::smoothed()).
  std::vector<OdometryEstimate> smoothed(std::map<int, FixAntenna>* antennas = nullptr) const {
    return odometry_.smoothed(antennas);
  }

  Timing timing() const { return odometry_.timing(); }

  // After an exception of the above (Odometry::recover()).
  void recover(const std::exception_ptr& failure) { odometry_.recover(failure); }

  // Counts an input of `channel` that was lost or unusable.
  void reject(const std::string& channel, const std::string& reason);

 private:
  void obey(const Command& command);
  void reset(bool all);
  std::string map_path(const std::string& name) const;
  Outputs with_notices(Outputs outputs);

  std::string command_channel_;
  std::string state_directory_;
  std::vector<std::string> notices_;  // to go out with the next results
  Odometry odometry_;
};

}  // namespace gprodom
