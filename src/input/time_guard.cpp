#include "input/time_guard.h"

#include <algorithm>
#include <cstdlib>

namespace gprodom {

namespace {

constexpr char kSetAlone[] = "clock was set alone: its stamps are carried on";
constexpr char kJumpedAhead[] = "stamp jumped ahead";
constexpr char kJumpedBack[] = "stamp jumped back";
constexpr char kLate[] = "later than time.reorder_window";

}  // namespace

TimeGuard::TimeGuard(const TimeConfig& config) : reorder_(from_seconds(config.reorder_window)) {}

std::string TimeGuard::check(Source source, TimeNs& time) {
  if (time <= 0) return "stamp not after 1970";
  if (time > kLatest) return kJumpedAhead;
  Track& track = tracks_[source];
  const TimeNs stamp = time, now = tracks_[kImu].newest;
  time += track.offset;
  // The other sensors may have a clock of their own.
  if (source == kImu || std::abs(time + offset_ - now) < std::abs(time - now)) time += offset_;
  if (time <= 0) return kJumpedBack;
  if (time > kLatest) return kJumpedAhead;
  if (source != kImu && tracks_[kImu].newest == 0) {
    track.newest = time;
    return "before the first message of the IMU";
  }
  if (time == track.newest && source != kMoreGpr && source != kFix) return "stamp repeated";
  std::string reason = source == kImu ? check_imu(time, stamp) : check_other(source, time);
  if (!reason.empty()) return reason;
  if (source == kImu) ++imu_accepted_;
  track.strays = 0;
  // Another sensor may have been far ahead while the IMU was silent, or before it came.
  const bool astray = source != kImu && track.at_newest != imu_accepted_ &&
                      track.newest > tracks_[kImu].newest + reorder_;
  track.newest = astray ? time : std::max(track.newest, time);
  track.at_newest = imu_accepted_;
  return {};
}

std::string TimeGuard::check_imu(TimeNs time, TimeNs stamp) {
  if (tracks_[kImu].newest == 0) return {};
  const TimeNs ahead = time - tracks_[kImu].newest;
  if (std::abs(ahead) <= reorder_) return {};
  if (ahead < 0)
    return take_stray(time, stamp, ahead < -(kMaxJump + reorder_) ? kJumpedBack : kLate);
  if (ahead <= kLongestGap && confirmed_by_others(time, ahead <= kMaxJump)) return {};
  return take_stray(time, stamp, ahead > kMaxJump ? kJumpedAhead : "stamp ahead of all others");
}

// A stamp of the IMU out of reach: an error, unless the next ones agree with it. Then the clock was
// set, and is followed, or all sensors were silent.
std::string TimeGuard::take_stray(TimeNs time, TimeNs stamp, const char* reason) {
  Track& imu = tracks_[kImu];
  add_stray(imu, time);
  if (imu.strays == 1)
    for (Track& other : tracks_) other.at_imu_stray = other.newest;
  if (imu.strays < kStraysToFollow) return reason;
  if (time < imu.newest) {
    if (imu.strays < kStraysToSetBack || imu.stray - imu.first_stray < kAgree) return reason;
    carry_on(time, stamp);
    return "clock was set back: its stamps are carried on from where it was";
  }
  if (all_are_ahead(time)) return step_ahead();
  if (!others_had_time()) return reason;
  if (others_go_on()) {
    carry_on(time, stamp);
    return kSetAlone;
  }
  return moved() ? reason : "";
}

// The first stray came one interval after the IMU's newest stamp in reach.
void TimeGuard::carry_on(TimeNs time, TimeNs stamp) {
  Track& imu = tracks_[kImu];
  const TimeNs since_first = time - imu.first_stray;
  imu.newest += since_first + since_first / (imu.strays - 1);
  offset_ = imu.newest - stamp;
  imu.strays = 0;
}

// Whether the others could be heard since the IMU's stamps went astray: a fast IMU is heard often
// before a slow wheel is heard once.
bool TimeGuard::others_had_time() const {
  const Track& imu = tracks_[kImu];
  return imu.strays > 0 && imu.stray - imu.first_stray >= kRunning;
}

bool TimeGuard::moved() const {
  return others_had_time() && tracks_[kImu].stray > tracks_[kImu].newest + kLongestGap;
}

// Whether another sensor tells that the time of the IMU's strays is not now: its stamps were those
// of before when the IMU's jumped, and have gone on from there.
bool TimeGuard::others_go_on() const {
  const Track& imu = tracks_[kImu];
  return std::any_of(kSensors.begin(), kSensors.end(), [&](Source source) {
    const Track& other = tracks_[source];
    return other.at_imu_stray - imu.newest < (imu.first_stray - imu.newest) / 2 &&
           other.newest > other.at_imu_stray + kAgree && other.newest < imu.stray - reorder_;
  });
}

// Whether all other running sensors, at least one, jumped to that time together with the IMU.
// (Displacements of other processes are no sensor.) A jump of at most kLongestGap may as well be a
// silence of all, in which the robot has driven on.
bool TimeGuard::all_are_ahead(TimeNs time) const {
  const Track& imu = tracks_[kImu];
  if (time <= imu.newest + kLongestGap || time - imu.newest > kMostAhead - ahead()) return false;
  bool one = false;
  for (const Source source : kSensors) {
    const Track& other = tracks_[source];
    if (other.newest < imu.newest - kRunning) continue;
    const bool agrees = other.strays > 0 && other.at_first_stray == imu_accepted_ &&
                        std::abs(time - other.stray) <= reorder_;
    if (!agrees) return false;
    one = true;
  }
  return one;
}

std::string TimeGuard::step_ahead() {
  const Track& imu = tracks_[kImu];
  const TimeNs by = imu.first_stray - imu.newest;
  offset_ -= by;
  steps_.push_back({imu.newest, ahead() + by});
  for (Track& track : tracks_) track.strays = 0;
  return "clock was set ahead with those of all sensors: its stamps are carried on, odom goes on";
}

TimeNs TimeGuard::sensor_stamp(TimeNs time) const {
  const auto step = std::find_if(steps_.rbegin(), steps_.rend(),
                                 [time](const Step& each) { return time > each.from; });
  return step == steps_.rend() ? time : time + step->ahead;
}

std::string TimeGuard::check_other(Source source, TimeNs time) {
  Track& track = tracks_[source];
  // While the IMU is silent a sensor's own stamps go on.
  const bool imu_silent = track.at_newest == imu_accepted_;
  const TimeNs reference =
      imu_silent ? std::max(track.newest, tracks_[kImu].newest) : tracks_[kImu].newest;
  const TimeNs ahead = time - reference;
  if (ahead <= reorder_ && ahead >= -(reorder_ + (source == kFix ? kMaxJump : 0))) {
    track.accepted = {ahead, tracks_[kImu].newest};
    track.off = 0;
    return {};
  }
  if (std::count(kSensors.begin(), kSensors.end(), source) > 0 && was_set(track, ahead))
    return kSetAlone;
  if (ahead < 0) return ahead < -(kMaxJump + reorder_) ? kJumpedBack : kLate;
  if (track.at_first_stray != imu_accepted_) track.strays = 0;
  track.at_first_stray = imu_accepted_;
  add_stray(track, time);
  const Track& imu = tracks_[kImu];
  const bool with_imu =
      ahead > kLongestGap && imu.strays > 0 && std::abs(time - imu.stray) <= reorder_;
  if (track.strays >= kStraysToFollow && !with_imu) return {};  // with it: it decides
  return ahead > kMaxJump ? kJumpedAhead : "stamp ahead of the IMU's";
}

// Whether the sensor's clock alone was set, and then follows it: stamps are off by one time again
// and again, and the first of them came sooner after one in reach than a gap or a delay of so long
// allows. lag: from the IMU's newest stamp.
bool TimeGuard::was_set(Track& track, TimeNs lag) const {
  const TimeNs now = tracks_[kImu].newest;
  if (track.off == 0 || std::abs(lag - track.first_off.lag) > reorder_ / 2) {
    track.first_off = {lag, now};
    track.off = now - track.accepted.at < std::abs(lag - track.accepted.lag) ? 1 : 0;
    return false;
  }
  if (++track.off < kStraysToFollow || now - track.first_off.at < kAgree) return false;
  track.offset += track.accepted.lag - track.first_off.lag;
  track.off = 0;
  return true;
}

void TimeGuard::add_stray(Track& track, TimeNs time) const {
  const bool agrees = track.strays > 0 && time > track.stray && time < track.stray + kMaxJump;
  if (!agrees) track.first_stray = time;
  track.strays = agrees ? track.strays + 1 : 1;
  track.stray = time;
}

// after_a_pause: others that have not been followed yet confirm it, too.
bool TimeGuard::confirmed_by_others(TimeNs time, bool after_a_pause) const {
  return std::any_of(tracks_.begin() + 1, tracks_.end(), [&](const Track& other) {
    const bool jumped_too =
        after_a_pause && other.strays > 0 && other.at_first_stray == imu_accepted_;
    return (other.newest > 0 && std::abs(time - other.newest) <= reorder_) ||
           (jumped_too && std::abs(time - other.stray) <= reorder_);
  });
}

TimeNs TimeGuard::newest_of_others() const {
  TimeNs newest = 0;
  for (std::size_t i = 1; i < tracks_.size(); ++i) newest = std::max(newest, tracks_[i].newest);
  return newest;
}

}  // namespace gprodom
