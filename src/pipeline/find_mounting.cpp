// The mounting of the IMU where the configuration leaves it to the drive (imu.rpy_body_imu: auto).
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "estimation/revised_state.h"
#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

// An IMU that an earlier run has found so is tilted by no more than a slope.
constexpr double kSteepest = 0.35;  // rad

// Estimated again once the mounting is known.
constexpr double kMoved_m = 0.1;
constexpr std::size_t kMostHeard = 200'000;  // messages
constexpr TimeNs kAgain = 60 * kSecond, kStandstill = 12 * kSecond;

constexpr double kDegree = M_PI / 180;

}  // namespace

void Pipeline::find_mounting(const StartingPoint& start) {
  search_.emplace();
  searched_to_ = start.mounting_of;
  if (start.mounting) {
    imu_mounting_.level(start.mounting->q_body_imu.toRotationMatrix());
    search_->resume(start.mounting->yaw_sigma);
    if (search_->known()) imu_mounting_.turn(Eigen::Matrix3d::Identity());
  }
  motion_.set_axes_known(search_->known());
  hears_ = start.hears && (!search_->known() || start.mounting_of > 0);
}

// Before the start. A mounting that an earlier run has found is kept, unless gravity contradicts
// it.
void Pipeline::level_imu() {
  if (!search_) return;
  forget_heard();
  const auto up = motion_.mean_force();
  if (!up || up->isZero()) return;
  if (search_->known()) {
    if (std::acos(up->normalized().z()) < kSteepest) return;
    out_.warnings.emplace_back(
        "the IMU is mounted otherwise than in the last run: its mounting is found anew");
    search_.emplace();
    motion_.set_axes_known(search_->known());
  }
  const Eigen::Matrix3d R = levelled(*up);
  imu_mounting_.level(R);
  motion_.turn_axes(R);
}

// Before the next state, if the drive has shown more of it.
std::optional<Eigen::Matrix3d> Pipeline::take_mounting() {
  if (!search_) return std::nullopt;
  forget_heard();
  const auto turn = search_->take_turn();
  if (!turn) return std::nullopt;
  found_ = hears_;
  imu_mounting_.turn(*turn);
  motion_.turn_axes(*turn);
  motion_.set_axes_known(search_->known());
  mounting_ = {};
  const NavState& newest = motion_.newest().state;
  prediction_.rebase(motion_.newest(), motion_.noise(newest.time, imu_now_),
                     motion_.wheel_contact(), motion_.imu());
  const Eigen::Vector3d rpy = imu_mounting_.rpy();
  char said[160];
  std::snprintf(said, sizeof said,
                "IMU mounting found: imu.rpy_body_imu [%.3f, %.3f, %.3f], yaw +- %.0f degrees",
                rpy.x(), rpy.y(), rpy.z(), search_->yaw_sigma() / kDegree);
  out_.warnings.emplace_back(said);
  return turn;
}

// Data of a standstill show nothing beyond its last seconds.
void Pipeline::forget_heard() {
  if (!hears_) return;
  if (moves_since_ == 0 && prediction_.distance_m() > kMoved_m) moves_since_ = imu_now_;
  if (moves_since_ == 0) {
    const auto is_kept = [&](const Message& message) {
      const auto* imu = std::get_if<ImuSample>(&message);
      return imu && imu->time > imu_now_ - kStandstill;
    };
    heard_.erase(heard_.begin(), std::find_if(heard_.begin(), heard_.end(), is_kept));
  }
}

bool Pipeline::may_hear() const {
  const bool drives_on = moves_since_ > 0 && imu_now_ > moves_since_ + kAgain;
  return !search_->is_certain() && !drives_on && heard_.size() < kMostHeard;
}

void Pipeline::watch_mounting(const StateInput& input) {
  const auto wheel_m = motion_.wheel().distance(input.time);
  const Eigen::Vector3d& gyro_bias = prediction_.base().state.gyro_bias;
  if (!search_ || search_->known()) mounting_.add(input.steps, wheel_m, gyro_bias);
  const std::string& trouble = mounting_.trouble();
  if (!search_) {
    health_.set("IMU mounting", HealthLevel::kDegraded, trouble);
    return;
  }
  if (input.time > searched_to_) search_->add(input.steps, wheel_m, gyro_bias);
  if (!trouble.empty()) {
    health_.count("IMU mounting", "it has changed, and is found anew");
    search_.emplace();
    mounting_ = {};
    motion_.set_axes_known(search_->known());
  }
  health_.value("imu.yaw_sigma_rad", search_->yaw_sigma());
  const Eigen::Vector3d rpy = imu_mounting_.rpy();
  health_.value("imu.roll_rad", rpy.x());
  health_.value("imu.pitch_rad", rpy.y());
  health_.value("imu.yaw_rad", rpy.z());
  health_.await("IMU mounting", HealthLevel::kOk,
                search_->known() ? ""
                                 : "being found: accelerations count once starts, stops and bends "
                                   "have shown the IMU's yaw");
}

StartingPoint Pipeline::beginning_again() {
  StartingPoint start = learnt();
  start.pair = earlier_pair_;  // each datum counts once
  start.slip = earlier_slip_;
  if (search_->known()) start.mounting_of = imu_now_;
  start.begins_at = began_at_;
  start.hears = may_hear();
  start.ground = map_->take_ground();
  return start;
}

// Once the mounting is found, or found better, the data that have shown it are estimated again by a
// second pipeline. It hears kFaster messages for each new one, so that no pose waits for it. Then
// it takes over: odom goes on, but for what was estimated wrongly. Poses published before stay. The
// last one has a map, of the data since the start.
void Odometry::estimate_again(std::size_t most) {
  if (!again_ && (pipeline_->take_found() || !pipeline_->may_hear())) {
    again_ = made(pipeline_->beginning_again());
    if (records_) again_->record();
    heard_again_ = 0;
  }
  if (!again_) return;
  const auto& heard = pipeline_->heard();
  for (; heard_again_ < heard.size() && most > 0; ++heard_again_, --most) {
    again_->add(heard[heard_again_]);
    again_->step();
    again_->start_jobs();
    again_->drain();  // before the data time goes on
  }
  if (heard_again_ < heard.size()) return;
  if (pipeline_->told()) again_->locate_at(*pipeline_->told());
  use(std::move(again_));
}

}  // namespace gprodom
