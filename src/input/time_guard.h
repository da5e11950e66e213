// Decides which stamps can be used. The IMU's stamps are the clock, and those of the other sensors
// are compared with it: one sensor with a wrong clock must not make all others look late.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

class TimeGuard {
 public:
  // kMoreGpr: all antennas but the one that the estimator follows. Channels of one radar may have
  // equal stamps. So may fixes of several antennas, which also may come later than other sensors'
  // messages: they have no part in `odom`.
  enum Source { kImu, kWheel, kWheels, kGpr, kDisplacement, kFix, kMoreGpr };

  // ns. A driver or a network holds data back for less; a clock that differs by more was set.
  static constexpr TimeNs kMaxJump = 5'000'000'000;

  explicit TimeGuard(const TimeConfig& config);

  // Returns the reason to drop the stamp; empty if it is usable. If the clock was set while the
  // estimator ran (back; or ahead, together with those of all other running sensors), the stamp is
  // changed to continue the time before.
  std::string check(Source source, TimeNs& time);

  // From the continued time to the sensors' own clock, for outputs. After the clock was set ahead
  // it is later; after it was set back it is the same, since no output may be earlier than before.
  TimeNs sensor_stamp(TimeNs time) const;

  // Newest stamp of any sensor other than the IMU; 0 before the first. Before the first message of
  // the IMU these stamps are neither checked nor used.
  TimeNs newest_of_others() const;

  // The IMU's clock alone was set ahead: many of its messages in a row agreed on a time far ahead,
  // and the other sensors did not. The estimator must start again.
  bool moved() const { return tracks_[kImu].strays >= kStraysToMove && others_had_time(); }

 private:
  static constexpr int kStraysToMove = 50;  // agreeing, of a clock that was set
  // A stamp ahead of all others is an error of one message, unless the next ones agree with it.
  static constexpr int kStraysToFollow = 3;
  static constexpr TimeNs kRunning = 1'000'000'000;  // ns; a sensor is heard within it if it runs
  static constexpr TimeNs kMostAhead =
      3'000'000'000'000'000'000;                          // ns, sum of steps that are followed
  static constexpr TimeNs kLongestGap = 100'000'000'000;  // ns; after a longer gap: start again

  struct Track {
    TimeNs newest = 0;
    TimeNs first_stray = 0;   // first of the agreeing stamps that are out of reach
    TimeNs stray = 0;         // the newest of them
    int strays = 0;           // their number
    long at_newest = 0;       // imu_accepted_ when `newest` came
    long at_first_stray = 0;  // imu_accepted_ when `first_stray` came
  };

  std::string check_imu(TimeNs time, TimeNs stamp);
  std::string take_stray(TimeNs time, TimeNs stamp, const char* reason);
  bool others_had_time() const;
  bool all_were_silent(TimeNs time) const;
  bool all_are_ahead(TimeNs time) const;
  std::string step_ahead();
  TimeNs ahead() const { return steps_.empty() ? 0 : steps_.back().ahead; }
  std::string check_other(Source source, TimeNs time);
  bool confirmed_by_others(TimeNs time) const;
  void add_stray(Track& track, TimeNs time) const;

  TimeNs reorder_;
  std::array<Track, 7> tracks_;
  long imu_accepted_ = 0;
  TimeNs offset_ = 0;  // from stamps to the continued time, since the clock was set

  struct Step {
    TimeNs from;   // continued time at the step
    TimeNs ahead;  // the clock less the continued time, after this step
  };
  std::vector<Step> steps_;
};

}  // namespace gprodom
