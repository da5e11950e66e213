#include "map/map_task.h"

#include <cmath>
#include <utility>

#include "map/map_frame.h"

namespace gprodom {
namespace {

constexpr TimeNs kJobPeriod = 500'000'000;
constexpr std::size_t kMostWaiting = 2000;  // traces or revisits that wait for a state

// How long to wait for a late answer. Beyond it the correction comes later.
constexpr std::chrono::milliseconds kPatience(200);

}  // namespace

Correction correction_by(const MapPose& settled, const OdometryEstimate& now) {
  const double yaw = settled.in_map.pose.yaw - settled.in_odom.pose.yaw;
  const Eigen::Rotation2Dd turn(yaw);
  const Eigen::Vector2d here = now.p_odom_body.head<2>();
  const double longer =
      std::exp(settled.in_map.slip) * settled.in_odom.scale / settled.in_map.scale;
  const Eigen::Vector2d in_map =
      settled.in_map.pose.p + longer * (turn * (here - settled.in_odom.pose.p));
  Correction correction;
  correction.time = now.time;
  correction.q_map_odom = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  correction.p_map_odom << in_map - turn * here, 0.0;
  correction.revisits = settled.revisits;
  correction.covariance = now.pose_covariance;
  const Eigen::Matrix3d planar =
      carried_covariance(correction, settled.in_map.covariance.topLeftCorner<3, 3>(),
                         planar_estimate(settled.in_odom), now);
  set_planar_block(planar, correction.covariance);
  return correction;
}

MapTask::MapTask(const Config& config, Execution execution, std::optional<GroundMap> before,
                 std::optional<Mapper::Start> start)
    : enabled_(config.gpr.enabled && config.graph.enabled),
      taken_from_(before ? before->taken_from() : 0),
      latency_(from_seconds(config.graph.latency)),
      mapper_(config, std::move(before), std::move(start)),
      worker_(execution) {}

void MapTask::add(const GprTrace& trace) {
  if (!enabled_) return;
  traces_.push_back(trace);
  if (traces_.size() > kMostWaiting) traces_.pop_front();
}

void MapTask::add(const Displacement& revisit) {
  if (enabled_ && next_.revisits.size() < kMostWaiting) next_.revisits.push_back(revisit);
}

void MapTask::add(const StateResult& result, TimeNs effective) {
  if (!enabled_) return;
  unsettled_.push_back(path_state(result));
  if (!result.settled) return;
  while (!unsettled_.empty() && unsettled_.front().time < result.settled->time) {
    unsettled_.pop_front();
  }
  if (unsettled_.empty() || unsettled_.front().time != result.settled->time) return;
  settle(unsettled_.front(), result);
  next_.states.push_back(unsettled_.front());
  unsettled_.pop_front();
  next_.scale = result.state.wheel_scale;
  next_.scale_sigma = std::sqrt(result.covariance(row::kScale, row::kScale));
  if (effective - last_submitted_ >= kJobPeriod) submit(effective);
}

void MapTask::submit(TimeNs effective) {
  last_submitted_ = effective;
  const TimeNs newest = next_.states.back().time;
  while (!traces_.empty() && traces_.front().time <= newest) {
    next_.traces.push_back(std::move(traces_.front()));
    traces_.pop_front();
  }
  worker_.submit(effective + latency_, [this, input = std::exchange(next_, {})] {
    try {
      return mapper_.run(input);
    } catch (const std::exception& error) {
      throw MapFailure(std::string("map: ") + error.what());
    } catch (...) {
      throw MapFailure("map: not a std::exception");
    }
  });
}

void MapTask::save_ground(TimeNs now, bool main, std::function<void(SavedGround)> take) {
  worker_.submit(now + latency_, [this, main, take = std::move(take)] {
    take(mapper_.saved_ground(main));
    return MapAnswer{};
  });
}

void MapTask::save_newest(TimeNs now, std::function<void(SavedGround)> take) {
  worker_.submit(now + latency_, [this, take = std::move(take)] {
    take(mapper_.newest_ground());
    return MapAnswer{};
  });
}

GroundMap MapTask::take_ground() {
  drain();
  return mapper_.take_ground();
}

SavedGround MapTask::saved_ground() {
  drain();
  return mapper_.saved_ground(false);
}

std::optional<MapAnswer> MapTask::next_due(TimeNs now) {
  const auto due = worker_.await_due(now, kPatience);
  if (!due || !due->result) return std::nullopt;
  MapAnswer answer = *due->result;
  for (Displacement& d : answer.revisits) d.time = due->effective;
  if (answer.pose) pose_ = answer.pose;
  return answer;
}

std::optional<Correction> MapTask::correct(const OdometryEstimate& estimate) {
  if (!pose_) return std::nullopt;
  return correction_by(*std::exchange(pose_, std::nullopt), estimate);
}

}  // namespace gprodom
