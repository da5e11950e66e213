// Which stamps can be used. The IMU's are the clock; the other sensors' are held against it, since
// one sensor whose clock is off must not make the data of all others look late.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

class TimeGuard {
 public:
  enum Source { kImu, kWheel, kWheels, kGpr, kDisplacement };

  explicit TimeGuard(const TimeConfig& config);

  // Empty where the stamp is usable, else the reason to drop it. A stamp of a clock that was set
  // while the estimator ran becomes one of the time that goes on: back, from where the clock was
  // before; ahead, with those of all other running sensors, likewise.
  std::string check(Source source, TimeNs& time);

  // What the sensors' clock told at such a time. Later than it where the clock was set ahead; where
  // it was set back the same, since nothing may be stamped earlier than before.
  TimeNs told(TimeNs time) const;

  // Newest stamp of any other sensor than the IMU, 0 before the first. Before the IMU's first
  // message they are not checked, and none is usable.
  TimeNs newest_of_others() const;

  // True once many of the IMU's messages in a row agreed on a time out of reach ahead, and the
  // other sensors did not: its clock was set, and the estimator must start afresh.
  bool moved() const { return tracks_[kImu].strays >= kStraysToMove; }

 private:
  static constexpr int kStraysToMove = 50;
  // Stamps ahead of all others are an error of one message unless the next ones agree.
  static constexpr int kStraysToFollow = 3;
  static constexpr TimeNs kRunning = 1'000'000'000;  // ns; heard so lately: a sensor runs
  static constexpr TimeNs kMostAhead = 3'000'000'000'000'000'000;  // ns in all; beyond: afresh
  static constexpr TimeNs kLongestGap = 100'000'000'000;  // ns; the IMU away for longer: afresh

  struct Track {
    TimeNs newest = 0;
    TimeNs first_stray = 0;   // of the stamps out of reach
    TimeNs stray = 0;         // newest of them
    int strays = 0;           // that agree
    long at_newest = 0;       // imu_accepted_ then
    long at_first_stray = 0;  // and then
  };

  std::string check_imu(TimeNs time, TimeNs told);
  std::string take_stray(TimeNs time, TimeNs told, const char* reason);
  bool all_are_ahead(TimeNs time) const;
  std::string step_ahead();
  TimeNs ahead() const { return steps_.empty() ? 0 : steps_.back().ahead; }
  std::string check_other(Track& track, TimeNs time) const;
  bool told_by_others(TimeNs time) const;
  void add_stray(Track& track, TimeNs time) const;

  TimeNs reorder_, max_jump_;
  std::array<Track, 5> tracks_;
  long imu_accepted_ = 0;
  TimeNs offset_ = 0;  // from stamps to the time that goes on, since the clock was set

  struct Step {
    TimeNs from;   // after this time that goes on
    TimeNs ahead;  // the clock told more than it, by all steps so far
  };
  std::vector<Step> steps_;
};

}  // namespace gprodom
