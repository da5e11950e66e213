// How a pipeline continues from an earlier one or from a saved run, and what it saves.
#include <malloc.h>

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "map/map_frame.h"
#include "pipeline/pipeline.h"

namespace gprodom {

// Continues from a state that was saved seconds ago. The time since then is treated as a gap of all
// sensors, except that the wheel has counted on.
bool Pipeline::resume() {
  const SavedState saved = *std::exchange(saved_, std::nullopt);
  const NavState& x = saved.state;
  const double age = to_seconds(imu_now_ - x.time);
  if (!(age > 0.0 && age <= config_.state.resume_within)) {
    out_.warnings.push_back(formatted(
        "the saved pose is %.0f s old (state.resume_within): starting at the initialiser", age));
    motion_.forget_wheel();
    return false;
  }
  stop_buffering();  // what comes does not begin at the origin
  out_.warnings.push_back(formatted("resumed from the pose saved %.1f s before", age));
  imu_mounting_.divide_forces(saved.accel_scale);
  motion_.divide_forces(saved.accel_scale);
  // IMU samples of a straight path at constant speed.
  const Eigen::Vector3d up_body =
      x.q_odom_body.conjugate() * Eigen::Vector3d(0, 0, kStandardGravity);
  for (const TimeNs time : {x.time, imu_now_ - from_seconds(std::min(0.01, 0.5 * age))})
    motion_.add(ImuSample{time, up_body + x.accel_bias, x.gyro_bias});
  StateResult result;
  result.state = x;
  result.covariance = saved.covariance;
  result.solve.usable = true;
  result.bridged = true;
  prediction_.resume(saved.distance_m);
  begin({x, gaussian_prior(x, saved.covariance), saved.noise, false, saved.accel_scale}, result);

  if (saved.map < 0) return true;  // the map is another one: the robot has to find its place in it
  resumed_correction_ = saved.correction;
  const Correction correction = saved.correction.value_or(Correction{});
  const Eigen::Vector3d ahead = correction.q_map_odom * Eigen::Vector3d::UnitX();
  TrackStart start;
  start.map_from_track = {correction.p_map_odom.head<2>(), std::atan2(ahead.y(), ahead.x())};
  start.map = map_number_ = saved.map;
  start.since = path_state(result);
  // While map is odom, the pose in map is as sure as that in odom.
  start.covariance = saved.correction ? planar_block(correction.covariance)
                                      : Eigen::Matrix3d(start.since.pose_covariance);
  map_ = std::make_unique<MapTask>(config_, execution_, map_->take_ground(), start);
  if (record_) map_->record();
  return true;
}

std::optional<SavedState> Pipeline::state(const std::optional<Correction>& correction) const {
  const StateResult& base = prediction_.base();
  if (!started_ || !base.solve.usable) return std::nullopt;
  SavedState saved;
  saved.state = base.state;
  saved.state.time =
      sensor_stamp(base.state.time);  // the sensors' own stamp, which a later run will have
  saved.covariance = base.covariance;
  // What this adds has moved the pose for good; the next run counts its own from zero.
  saved.covariance.block<2, 2>(row::kP, row::kP) += base.unmodelled_covariance;
  saved.noise = motion_.noise_at_standstill();
  saved.accel_scale = imu_mounting_.accel_scale();
  saved.wheel_m = motion_.wheel().reported(base.state.time);
  saved.distance_m = prediction_.distance_m();
  saved.correction = correction;
  saved.map = map_number_;
  saved.ground = map_->taken_from();
  return saved;
}

StartingPoint Pipeline::learnt() const {
  StartingPoint next;
  next.pair = motion_.pair().learnt();
  next.slip = motion_.learnt_slip();
  next.accel_scale = imu_mounting_.accel_scale();
  if (started_ && !search_.is_configured()) next.mounting = learnt_mounting();
  return next;
}

void Pipeline::drain() {
  solver_.drain();
  radar_worker_.drain();
  map_->drain();
}

void Pipeline::set_ground(GroundMap ground) {
  ground_format_ = ground.known_format();
  has_earlier_ground_ = !ground.places.empty();
  located_ = false;
  map_ = std::make_unique<MapTask>(config_, execution_, std::move(ground));
  // Reading a map needs several times the memory in which it is kept. What is freed of that stays
  // with the allocator unless it is asked.
  malloc_trim(0);
}

}  // namespace gprodom
