// What one run leaves to the next, in the files of state.directory: pose, wheel scale and ground.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/file_writer.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "map/ground_map.h"
#include "persist/saved_state.h"
#include "persist/saved_wheel.h"

namespace gprodom {

class StateStore {
 public:
  // config: as it was read. Removes from the folder what a power cut has left of a saving.
  explicit StateStore(const Config& config);

  bool enabled() const { return !directory_.empty(); }
  // state.map: read_only writes none, not by command either.
  bool writes_ground() const { return config_.state.map != MapUse::kReadOnly; }

  // The configuration, with the scale of the last run as the prior of the wheel's scale. It is not
  // changed if there is no saved scale, if the scale is held or configured more precisely, if the
  // wheel is another one, or if the scale contradicts the configured prior. This and the next four
  // functions add to notices what was found, or why it cannot be used.
  Config config_with_wheel_scale(std::vector<std::string>& notices) const;
  // How much the wheel slipped in the last run, and where it is, if it is the same wheel.
  std::optional<slip::Learnt> slip(std::vector<std::string>& notices) const;
  // The turn calibration of the last run, if the configured wheels are the same and the expected
  // track is not another one.
  std::optional<LearntTurn> pair(std::vector<std::string>& notices) const;
  // The saved state. If it is of another wheel, it gets the configured scale.
  std::optional<SavedState> state(std::vector<std::string>& notices) const;
  std::optional<GroundMap> ground(const gpr::TraceMemoryOptions& options,
                                  std::vector<std::string>& notices) const;

  // Whether a saving is due at this data time. If it is, the next period begins now.
  bool state_is_due(TimeNs now) { return is_due(now, state_period_, last_state_); }
  bool ground_is_due(TimeNs now) {
    return writes_ground() && is_due(now, ground_period_, last_ground_);
  }

  // In the background. estimate: whose scale is kept.
  void save(const OdometryEstimate& estimate, const std::optional<SavedState>& state);
  void save(const LearntTurn& pair);
  void save(const slip::Learnt& slip);

  std::string ground_path() const { return directory_ + "/ground.map"; }
  FileWriter& writer() { return writer_; }

  // The saving of this path was requested by name, so its outcome goes to the notices.
  void await(const std::string& path) { awaited_.push_back(path); }
  std::vector<std::string> take_notices();
  // The errors of files whose last writing failed; empty if there are none.
  std::string trouble() const;

 private:
  bool is_due(TimeNs now, TimeNs period, TimeNs& last) const;

  std::string why_not(const SavedWheel& wheel) const;
  std::string why_not(const SavedPair& pair) const;

  const Config config_;
  const std::string wheel_setting_;
  std::string directory_;  // empty: nothing is kept
  TimeNs state_period_, ground_period_;
  TimeNs last_state_ = 0, last_ground_ = 0;
  std::vector<std::string> awaited_;            // paths
  std::map<std::string, std::string> failing_;  // errors by path
  FileWriter writer_;
};

}  // namespace gprodom
