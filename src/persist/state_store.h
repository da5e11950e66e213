// What one run leaves to the next, in the files of state.directory: pose, wheel scale and ground.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/file_writer.h"
#include "base/folder_lock.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "map/ground_files.h"
#include "map/ground_map.h"
#include "persist/learnt.h"
#include "persist/saved_state.h"

namespace gprodom {

class StateStore {
 public:
  // config: as it was read. Locks the folder, and removes from it what a power cut has left of a
  // saving. Throws FileError if another user has locked it.
  explicit StateStore(const Config& config);

  bool enabled() const { return !directory_.empty(); }
  // Of users that share the folder (read_only) the first alone keeps pose, wheel and slip in it.
  bool keeps_state() const { return enabled() && (!lock_.held() || lock_.first()); }
  // state.map: read_only writes none, not by command either.
  bool writes_ground() const { return config_.state.map != MapUse::kReadOnly; }

  // The configuration, with the scale of the last run as the prior of the wheel's scale. It is not
  // changed if there is no saved scale, if the scale is held or configured more precisely, if the
  // wheel is another one, or if the scale contradicts the configured prior. This and the next five
  // functions add to notices what was found, or why it cannot be used.
  Config config_with_wheel_scale(std::vector<std::string>& notices) const;
  // How much the wheel slipped in the last run, and where it is, if it is the same wheel.
  std::optional<slip::Learnt> slip(std::vector<std::string>& notices) const;
  // The turn calibration of the last run, if the configured wheels are the same and the expected
  // track is not another one.
  std::optional<LearntTurn> pair(std::vector<std::string>& notices) const;
  // The mounting of the IMU that the last run found, if the configuration leaves it to be found.
  std::optional<LearntMounting> mounting(std::vector<std::string>& notices) const;
  // The saved state. If it is of another wheel, it gets the configured scale.
  std::optional<SavedState> state(std::vector<std::string>& notices) const;
  std::optional<GroundMap> ground(const gpr::TraceMemoryOptions& options,
                                  std::vector<std::string>& notices) const;

  // Locks a folder that was not there at the start. False if another user has it; trouble() says
  // so. Call it before a saving.
  bool is_locked();

  // Whether a saving is due at this data time. If it is, the next period begins now.
  bool state_is_due(TimeNs now) { return is_due(now, state_period_, last_state_); }
  // Of the whole ground, and of what is new of it.
  bool ground_is_due(TimeNs now) {
    if (std::exchange(needs_whole_, false)) last_ground_ = now - ground_period_;
    return writes_ground() && is_due(now, ground_period_, last_ground_) && is_locked();
  }
  bool newest_is_due(TimeNs now) {
    return writes_ground() && is_due(now, newest_period_, last_newest_) && is_locked();
  }

  // In the background. estimate: whose scale is kept.
  void save(const OdometryEstimate& estimate, const std::optional<SavedState>& state);
  void save(const LearntTurn& pair);
  void save(const slip::Learnt& slip);
  void save(const LearntMounting& mounting);

  // The file of the ground: ground.map, or, where that has ground of another setting of the radar,
  // one that is named after the setting.
  std::string ground_path() const { return directory_ + "/" + ground_name_ + ".map"; }
  void use_ground_of(const TraceFormat& format);
  void use_main_ground() { ground_name_ = kMainGround; }
  bool uses_main_ground() const { return ground_name_ == kMainGround; }
  // What to say while it is not ground.map.
  const std::string& other_format() const { return other_format_; }
  FileWriter& writer() { return writer_; }

  // In the background, as GroundFiles::replace() does. Ground of which nothing is stored is written
  // only if asked for by name, and then fails where a file holds more.
  void save_ground(const std::string& path, SavedGround ground, bool asked);
  // Its own jobs are on the writer's thread: only after writer().flush().
  GroundFiles& ground_files() { return ground_files_; }
  // What GroundFiles told, also of calls from outside: for the notices, and for kept_aside().
  void tell(const std::vector<std::string>& told, std::vector<std::string>& notices);
  // Of the map files that were set aside in this run: the last, and why. Empty if there is none.
  const std::string& kept_aside() const { return kept_aside_; }

  // The saving of this path was requested by name, so its outcome goes to the notices.
  void await(const std::string& path) { awaited_.push_back(path); }
  std::vector<std::string> take_notices();
  // Whether the last writing of this file failed.
  bool failed(const std::string& path) const { return failing_.count(path) > 0; }
  // The errors of files whose last writing failed; empty if there are none.
  std::string trouble() const;

 private:
  template <typename Saved>
  std::optional<Saved> read(const std::string& path, std::vector<std::string>& notices,
                            Saved (*parse)(const std::string&, std::string_view)) const;
  template <typename Saved>
  void write(const char* file, const Saved& saved);
  bool is_due(TimeNs now, TimeNs period, TimeNs& last) const;

  std::string why_not(const SavedWheel& wheel) const;
  std::string why_not(const SavedPair& pair) const;

  static constexpr const char* kMainGround = "ground";

  const Config config_;
  const std::string wheel_setting_;
  std::string directory_;  // empty: nothing is kept
  TimeNs state_period_, ground_period_, newest_period_;
  TimeNs last_state_ = 0, last_ground_ = 0, last_newest_ = 0;
  bool needs_whole_ = false;                    // newest ground belongs to no file
  std::vector<std::string> awaited_;            // paths
  std::map<std::string, std::string> failing_;  // errors by path
  std::string kept_aside_;
  std::string ground_name_ = kMainGround, other_format_;
  FolderLock lock_;
  GroundFiles ground_files_;
  FileWriter writer_;  // its jobs use the above
};

}  // namespace gprodom
