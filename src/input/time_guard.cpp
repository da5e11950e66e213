#include "input/time_guard.h"

#include <algorithm>
#include <cstdlib>

namespace gprodom {

TimeGuard::TimeGuard(const TimeConfig& config) : reorder_(from_seconds(config.reorder_window)) {}

std::string TimeGuard::check(Source source, TimeNs& time) {
  if (time <= 0) return "stamp not after 1970";
  Track& track = tracks_[source];
  const TimeNs stamp = time, now = tracks_[kImu].newest;
  // The other sensors may have a clock of their own.
  if (source == kImu || std::abs(stamp + offset_ - now) < std::abs(stamp - now)) time += offset_;
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
  Track& imu = tracks_[kImu];
  if (imu.newest == 0) return {};
  const TimeNs ahead = time - imu.newest;
  if (ahead < -(kMaxJump + reorder_)) return take_stray(time, stamp, "stamp jumped back");
  if (ahead < -reorder_) return "later than time.reorder_window";
  if (ahead <= reorder_ || (ahead <= kLongestGap && confirmed_by_others(time))) return {};
  if (ahead > kMaxJump) return take_stray(time, stamp, "stamp jumped ahead");
  add_stray(imu, time);
  return imu.strays >= kStraysToFollow ? "" : "stamp ahead of all others";
}

// A stamp of the IMU out of reach. The clock was set, and is followed, if a few such stamps agree
// with each other and with all other sensors, or if many agree and lie before the newest stamp.
std::string TimeGuard::take_stray(TimeNs time, TimeNs stamp, const char* reason) {
  Track& imu = tracks_[kImu];
  add_stray(imu, time);
  if (imu.strays >= kStraysToFollow && all_are_ahead(time)) return step_ahead();
  if (all_were_silent(time)) return {};
  if (imu.strays < kStraysToMove || stamp > imu.newest + ahead()) return reason;
  offset_ = imu.newest + (time - imu.first_stray) - stamp;
  imu.strays = 0;
  return "clock was set back: its stamps are carried on from where it was";
}

// Whether the others could be heard since the IMU's stamps went astray: a fast IMU is heard often
// before a slow wheel is heard once.
bool TimeGuard::others_had_time() const {
  const Track& imu = tracks_[kImu];
  return imu.stray - imu.first_stray >= kRunning;
}

// Whether no other sensor was heard between the newest stamp of the IMU and that time: it was the
// same gap for all, even if no other sensor has come back yet.
bool TimeGuard::all_were_silent(TimeNs time) const {
  const Track& imu = tracks_[kImu];
  if (time < imu.newest || time > imu.newest + kLongestGap || !others_had_time()) return false;
  return std::none_of(tracks_.begin() + 1, tracks_.end(), [&](const Track& other) {
    return other.newest > imu.newest + reorder_ && other.newest < time - reorder_;
  });
}

// Whether all other running sensors, at least one, jumped to that time together with the IMU.
// (Displacements of other processes are no sensor.) A jump of at most kLongestGap may as well be a
// silence of all, in which the robot has driven on.
bool TimeGuard::all_are_ahead(TimeNs time) const {
  const Track& imu = tracks_[kImu];
  if (time <= imu.newest + kLongestGap || time - imu.newest > kMostAhead - ahead()) return false;
  bool one = false;
  for (const Source source : {kWheel, kWheels, kGpr}) {
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
  if (ahead < -(kMaxJump + reorder_)) return "stamp jumped back";
  if (ahead < -reorder_ && source != kFix) return "later than time.reorder_window";
  if (ahead <= reorder_) return {};
  if (track.at_first_stray != imu_accepted_) track.strays = 0;
  track.at_first_stray = imu_accepted_;
  add_stray(track, time);
  const Track& imu = tracks_[kImu];
  const bool with_imu =
      ahead > kLongestGap && imu.strays > 0 && std::abs(time - imu.stray) <= reorder_;
  if (track.strays >= kStraysToFollow && !with_imu) return {};  // with it: it decides
  return ahead > kMaxJump ? "stamp jumped ahead" : "stamp ahead of the IMU's";
}

void TimeGuard::add_stray(Track& track, TimeNs time) const {
  const bool agrees = track.strays > 0 && time > track.stray && time < track.stray + kMaxJump;
  if (!agrees) track.first_stray = time;
  track.strays = agrees ? track.strays + 1 : 1;
  track.stray = time;
}

bool TimeGuard::confirmed_by_others(TimeNs time) const {
  return std::any_of(tracks_.begin() + 1, tracks_.end(), [&](const Track& other) {
    return other.newest > 0 && std::abs(time - other.newest) <= reorder_;
  });
}

TimeNs TimeGuard::newest_of_others() const {
  TimeNs newest = 0;
  for (std::size_t i = 1; i < tracks_.size(); ++i) newest = std::max(newest, tracks_[i].newest);
  return newest;
}

}  // namespace gprodom
