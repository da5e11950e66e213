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
  // estimator ran, that of one sensor or of all, the stamp is changed to continue the time before.
  std::string check(Source source, TimeNs& time);

  // From the continued time to the sensors' own clock, for outputs. After the clock was set ahead
  // it is later; after it was set back it is the same, since no output may be earlier than before.
  TimeNs sensor_stamp(TimeNs time) const;

  // Newest stamp of any sensor other than the IMU; 0 before the first. Before the first message of
  // the IMU these stamps are neither checked nor used.
  TimeNs newest_of_others() const;

  // The IMU's stamps have jumped ahead for good, by so much that no gap is bridged, and no other
  // sensor tells the time. The estimator must start again.
  bool moved() const;

 private:
  static constexpr std::array kSensors{kWheel, kWheels, kGpr};  // whose stamps tell the time, too
  // A stamp ahead of all others is an error of one message, unless the next ones agree with it.
  static constexpr int kStraysToFollow = 3;
  // So many late stamps of the IMU in a row show that its clock was set back. Where one message in
  // five is late, ten in a row are by chance with the probability 1e-7.
  static constexpr int kStraysToSetBack = 10;
  static constexpr TimeNs kRunning = 1'000'000'000;  // ns; a sensor is heard within it if it runs
  static constexpr TimeNs kAgree = 500'000'000;      // ns; least time over which such stamps agree
  static constexpr TimeNs kMostAhead =
      3'000'000'000'000'000'000;  // ns, sum of steps that are followed
  static constexpr TimeNs kLatest = 4'000'000'000'000'000'000;  // ns, in 2096: sums stay in range
  static constexpr TimeNs kLongestGap = 100'000'000'000;  // ns; after a longer gap: start again

  struct Track {
    TimeNs newest = 0;
    TimeNs first_stray = 0;   // first of the agreeing stamps that are out of reach
    TimeNs stray = 0;         // the newest of them
    int strays = 0;           // their number
    long at_newest = 0;       // imu_accepted_ when `newest` came
    long at_first_stray = 0;  // imu_accepted_ when `first_stray` came
    // Of another sensor:
    TimeNs at_imu_stray = 0;  // `newest` when the IMU's first stray came
    struct Lag {
      TimeNs lag = 0, at = 0;  // its stamp less the IMU's newest one; that stamp of the IMU
    };
    Lag accepted, first_off;  // of the newest one in reach; of the first of those off by one time
    int off = 0;              // number of stamps off by that time, in a row
    TimeNs offset = 0;        // to its stamps, since its clock was set alone
  };

  std::string check_imu(TimeNs time, TimeNs stamp);
  std::string take_stray(TimeNs time, TimeNs stamp, const char* reason);
  bool others_had_time() const;
  bool others_go_on() const;
  bool all_are_ahead(TimeNs time) const;
  std::string step_ahead();
  TimeNs ahead() const { return steps_.empty() ? 0 : steps_.back().ahead; }
  void carry_on(TimeNs time, TimeNs stamp);
  std::string check_other(Source source, TimeNs time);
  bool was_set(Track& track, TimeNs lag) const;
  bool confirmed_by_others(TimeNs time, bool after_a_pause) const;
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
