// Replay: runs the estimator over a log, as fast as possible. The same input gives byte-identical
// output.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "gprodom/types.h"

namespace gprodom {

struct ReplayFiles {
  std::string input;
  std::string output;
  std::string trajectory;            // TUM, in map, as published at each time; empty: none
  std::string smoothed;              // TUM, in map from one solution over all data; empty: none
  std::string stats;                 // JSON, which the caller writes; empty: none
  std::vector<std::string> configs;  // read by the caller
};

// Statistics of a replay. Times are wall-clock, except log_seconds.
struct ReplayStats {
  std::map<std::string, long> read;       // messages by channel
  std::map<std::string, long> published;  // messages by channel
  long unused = 0;                        // messages on other channels
  long refused = 0;                       // messages that could not be decoded
  std::vector<std::string> damage;        // parts of the log that could not be read
  std::vector<std::string> warnings;
  long poses = 0;
  std::string why_no_pose;   // empty if there is one
  double log_seconds = 0.0;  // from the first event to the last
  double wall_seconds = 0.0;
  Timing timing;
  Status last_status;
  std::map<int, FixAntenna> antennas;  // as the smoothed solution finds them
};

struct ReplayHooks {
  std::function<void(double)> progress;  // 0 to 1, called every few hundred messages
  std::function<bool()> is_interrupted;  // likewise
};

// Writes all files completely, or none. Throws ConfigError, FileError, or std::runtime_error if
// interrupted.
ReplayStats replay(const Config& config, const ReplayFiles& files, const ReplayHooks& hooks);

// The statistics as a JSON object. `config_path` and the files are not part of it.
std::string to_json(const ReplayStats& stats);

}  // namespace gprodom
