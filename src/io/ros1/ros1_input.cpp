#include <algorithm>
#include <cmath>

#include "io/ros1/ros1_io.h"

namespace gprodom::ros1 {
namespace {

Eigen::Vector3d vector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }
Eigen::Vector3d vector(const geometry_msgs::Point& p) { return {p.x, p.y, p.z}; }
Eigen::Quaterniond rotation(const geometry_msgs::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

}  // namespace

TimeNs to_ns(const ros::Time& stamp) {
  return static_cast<TimeNs>(stamp.sec) * 1'000'000'000 + stamp.nsec;
}

ImuSample to_sample(const sensor_msgs::Imu& message) {
  ImuSample sample;
  sample.time = to_ns(message.header.stamp);
  sample.acceleration = vector(message.linear_acceleration);
  sample.angular_velocity = vector(message.angular_velocity);
  return sample;
}

GprTrace to_trace(const gprodom_ros::GprTrace& message) {
  GprTrace trace;
  trace.time = to_ns(message.header.stamp);
  trace.seq = message.trace;
  trace.antenna_id = message.antenna_id;
  trace.sample_interval_s = message.sample_interval;
  trace.time_zero_s = message.time_zero;
  trace.volts_per_count = message.volts_per_count;
  trace.samples.assign(message.samples.begin(), message.samples.end());
  return trace;
}

WheelSample WheelOdometry::add(const nav_msgs::Odometry& message) {
  const geometry_msgs::Pose& pose = message.pose.pose;
  if (last_) {
    const Eigen::Vector3d step = vector(pose.position) - vector(last_->position);
    if (!step.allFinite()) return {to_ns(message.header.stamp), step.sum()};  // refused later
    const Eigen::Quaterniond halfway =
        rotation(last_->orientation).slerp(0.5, rotation(pose.orientation));
    distance_m_ += std::copysign(step.norm(), step.dot(halfway * Eigen::Vector3d::UnitX()));
  }
  last_ = pose;
  return {to_ns(message.header.stamp), distance_m_};
}

std::optional<WheelSample> to_sample(const sensor_msgs::JointState& message,
                                     const std::string& joint, double radius_m) {
  const auto found = std::find(message.name.begin(), message.name.end(), joint);
  const auto index = static_cast<std::size_t>(found - message.name.begin());
  if (index >= message.name.size() || index >= message.position.size()) return std::nullopt;
  return WheelSample{to_ns(message.header.stamp), message.position[index] * radius_m};
}

}  // namespace gprodom::ros1
