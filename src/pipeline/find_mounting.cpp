// The mounting of the IMU where the drive shows it: where the configuration leaves it to be found
// (imu.rpy_body_imu: auto), or is contradicted.
#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

// An IMU that an earlier run has found so is tilted by no more than a slope.
constexpr double kSteepest = 0.35;  // rad

// Estimated again once the mounting is known.
constexpr double kMoved_m = 0.1;
constexpr std::size_t kMostBuffered = 32'000'000;  // bytes; 130 traces of 1000 samples a second
constexpr TimeNs kRerunWithin = 60 * kSecond;
// s, beyond initializer.duration; a start on the move waits no longer.
constexpr TimeNs kStartsWithin = 10 * kSecond;

constexpr double kDegree = M_PI / 180;

std::size_t bytes_of(const InputMessage& message) {
  const auto* trace = std::get_if<GprTrace>(&message);
  return sizeof message + (trace ? trace->samples.size() * sizeof trace->samples[0] : 0);
}

}  // namespace

void Pipeline::find_mounting(const StartingPoint& start) {
  searched_to_ = start.mounting_of;
  if (start.mounting)
    imu_mounting_.level(start.mounting->q_body_imu.toRotationMatrix() *
                        imu_mounting_.R_body_imu().transpose());
  if (start.search) {
    search_ = *start.search;
  } else if (start.mounting) {
    search_ = MountingSearch();
    search_.resume(start.mounting->yaw_sigma);
  }
  if (search_.known()) imu_mounting_.turn(Eigen::Matrix3d::Identity());
  motion_.set_axes_known(search_.known());
  buffers_ = start.buffers && (start.search || !start.mounting || !search_.known());
  map_waits_ = buffers_ && finds_mounting_;
}

// Before the start. A mounting that an earlier run has found is kept, unless gravity contradicts
// it.
void Pipeline::level_imu() {
  prune_buffer();
  if (!finds_mounting_) return;
  const auto up = motion_.mean_force();
  if (!up || up->isZero()) return;
  if (search_.known()) {
    if (std::acos(up->normalized().z()) < kSteepest) return;
    out_.warnings.emplace_back(
        "the IMU is mounted otherwise than in the last run: its mounting is found anew");
    search_ = MountingSearch();
    motion_.set_axes_known(false);
  }
  const Eigen::Matrix3d R = levelled(*up);
  imu_mounting_.level(R);
  motion_.turn_axes(R);
}

// Before the next state, if the drive has shown more of it.
std::optional<Eigen::Matrix3d> Pipeline::take_mounting() {
  prune_buffer();
  const auto turn = search_.take_turn();
  if (!turn) return std::nullopt;
  found_ = buffers_;
  imu_mounting_.turn(*turn);
  motion_.turn_axes(*turn);
  motion_.set_axes_known(true);
  mounting_ = {};
  const NavState& newest = motion_.newest().state;
  prediction_.rebase(motion_.newest(), motion_.noise(newest.time, imu_now_),
                     motion_.wheel_contact(), motion_.imu());
  out_.warnings.push_back("IMU mounting found: " + mounting_text());
  return turn;
}

std::string Pipeline::mounting_text() const {
  const Eigen::Vector3d rpy = imu_mounting_.rpy();
  return formatted("imu.rpy_body_imu [%.3f, %.3f, %.3f], yaw +- %.0f degrees", rpy.x(), rpy.y(),
                   rpy.z(), search_.yaw_sigma() / kDegree);
}

void Pipeline::buffer_message(const Message& message) {
  buffer_.push_back(message);
  buffer_bytes_ += bytes_of(message);
}

// Of a standstill what a start needs is kept.
void Pipeline::prune_buffer() {
  if (!buffers_) return;
  if (moves_since_ == 0 && prediction_.distance_m() > kMoved_m) moves_since_ = imu_now_;
  if (moves_since_ == 0) {
    const TimeNs from = imu_now_ - from_seconds(config_.initializer.duration) - kStartsWithin;
    const auto is_kept = [&](const Message& message) {
      const auto* imu = std::get_if<ImuSample>(&message);
      return imu && imu->time > from;
    };
    const auto kept = std::find_if(buffer_.begin(), buffer_.end(), is_kept);
    for (auto message = buffer_.begin(); message != kept; ++message)
      buffer_bytes_ -= bytes_of(*message);
    buffer_.erase(buffer_.begin(), kept);
  }
}

bool Pipeline::may_buffer() const {
  const bool drives_on = moves_since_ > 0 && imu_now_ > moves_since_ + kRerunWithin;
  return !search_.is_certain() && !drives_on && buffer_bytes_ < kMostBuffered;
}

void Pipeline::stop_buffering() {
  buffers_ = map_waits_ = false;
  buffer_.clear();
  buffer_bytes_ = 0;
}

// Of data since that time: what was driven before the start shows it as well.
void Pipeline::search_since(TimeNs from, const NavState& first) {
  for (TimeNs to = from + state_period_; to <= first.time; to += state_period_)
    search_mounting(to, motion_.imu().steps(to - state_period_, to), first.gyro_bias);
}

void Pipeline::search_mounting(TimeNs to, const std::vector<MotionStep>& steps,
                               const Eigen::Vector3d& gyro_bias) {
  const bool was_known = search_.known();
  if (to > searched_to_) search_.add(steps, motion_.wheel().distance(to), gyro_bias);
  const bool known = search_.known();
  if (known == was_known) return;
  if (!known) found_ = buffers_;  // the configured one is in doubt
  motion_.set_axes_known(known);
}

void Pipeline::watch_mounting(const StateInput& input) {
  const Eigen::Vector3d& gyro_bias = prediction_.base().state.gyro_bias;
  if (search_.known() || search_.is_configured())
    mounting_.add(input.steps, motion_.wheel().distance(input.time), gyro_bias);
  search_mounting(input.time, input.steps, gyro_bias);
  if (search_.is_configured()) {
    const bool vague = search_.is_contradicted() && mounting_.trouble().empty();
    health_.set("IMU mounting", HealthLevel::kDegraded,
                vague ? "accelerations contradict wheel and gyro, and do not count: "
                        "imu.rpy_body_imu or the sign of an axis is wrong"
                      : mounting_.trouble());
    return;
  }
  if (!mounting_.trouble().empty()) {
    health_.count("IMU mounting", "it has changed, and is found anew");
    search_ = MountingSearch();
    mounting_ = {};
    motion_.set_axes_known(false);
  }
  health_.value("imu.yaw_sigma_rad", search_.yaw_sigma());
  const Eigen::Vector3d rpy = imu_mounting_.rpy();
  health_.value("imu.roll_rad", rpy.x());
  health_.value("imu.pitch_rad", rpy.y());
  health_.value("imu.yaw_rad", rpy.z());
  const bool known = search_.known();
  health_.await("IMU mounting", known ? HealthLevel::kDegraded : HealthLevel::kOk,
                !known            ? "being found: accelerations count once starts, stops and bends "
                                    "have shown the IMU's yaw"
                : finds_mounting_ ? ""
                                  : "wheel and gyro contradict the configured one; in use is what "
                                    "they show: set imu.rpy_body_imu as imu.roll_rad, "
                                    "imu.pitch_rad and imu.yaw_rad say");
}

// Where a configured mounting was contradicted, the ground of this track lies wrongly.
StartingPoint Pipeline::rerun_start() {
  StartingPoint start = learnt();
  start.pair = earlier_pair_;  // each datum counts once
  start.slip = earlier_slip_;
  start.mounting = learnt_mounting();
  start.search = search_;
  start.mounting_of = imu_now_;
  start.begins_at = began_at_;
  start.buffers = may_buffer();
  start.ground = map_waits_ ? map_->take_ground() : map_->take_earlier_ground();
  map_waits_ = true;  // it is without ground from now on
  return start;
}

// Once the mounting is found, or found better, the data that have shown it are estimated again by a
// second pipeline. It takes kFaster messages for each new one, so that no pose waits for it. Then
// it takes over: odom goes on, but for what was estimated wrongly. Poses published before stay. The
// last one has a map, of the data since the start.
void Odometry::advance_rerun(std::size_t most) {
  const bool found = pipeline_->take_found(), ends = !pipeline_->may_buffer();
  if (!rerun_ && ends && !found && !pipeline_->map_waits()) pipeline_->stop_buffering();
  if (!rerun_ && pipeline_->buffers() && (found || ends)) {
    rerun_ = make_pipeline(pipeline_->rerun_start());
    if (records_) rerun_->record();
    rerun_messages_ = 0;
  }
  if (!rerun_) return;
  const auto& buffer = pipeline_->buffer();
  for (; rerun_messages_ < buffer.size() && most > 0; ++rerun_messages_, --most) {
    rerun_->add(buffer[rerun_messages_]);
    rerun_->step();
    rerun_->start_jobs();
    rerun_->drain();  // before the data time goes on
  }
  if (rerun_messages_ < buffer.size()) return;
  if (pipeline_->told()) rerun_->locate_at(*pipeline_->told());
  set_pipeline(std::move(rerun_));
}

}  // namespace gprodom
