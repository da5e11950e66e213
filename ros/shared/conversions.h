// Values of the estimator and messages of ROS, which have the same fields in ROS 1 and in ROS 2:
// the templates here are instantiated with the messages of either. Stamps differ, so they are left
// to the callers; `Odometry` is nav_msgs/Odometry, and so on.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "gprodom/input.h"
#include "gprodom/types.h"

namespace gprodom::ros_shared {

struct FrameNames {
  std::string map = "map";
  std::string odom = "odom";
  std::string body = "base_link";
};

template <class Vector>  // geometry_msgs/Vector3 or Point
Eigen::Vector3d vector(const Vector& v) {
  return {v.x, v.y, v.z};
}

template <class Quaternion>
Eigen::Quaterniond rotation(const Quaternion& q) {
  return {q.w, q.x, q.y, q.z};
}

template <class Vector>
void copy(const Eigen::Vector3d& from, Vector& to) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

template <class Quaternion>
void copy(const Eigen::Quaterniond& from, Quaternion& to) {
  to.w = from.w();
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

template <class Imu>
ImuSample to_imu(TimeNs time, const Imu& message) {
  return {time, vector(message.linear_acceleration), vector(message.angular_velocity)};
}

template <class Trace>  // GprTrace of gprodom_ros or of gprodom_msgs
GprTrace to_trace(TimeNs time, const Trace& message) {
  GprTrace trace;
  trace.time = time;
  trace.seq = message.trace;
  trace.antenna_id = message.antenna_id;
  trace.sample_interval_s = message.sample_interval;
  trace.time_zero_s = message.time_zero;
  trace.volts_per_count = message.volts_per_count;
  trace.samples.assign(message.samples.begin(), message.samples.end());
  return trace;
}

// The command locate_at of a PoseWithCovariance, with the larger of the standard deviations of x
// and y.
template <class PoseWithCovariance>
Command to_locate_at(TimeNs time, const PoseWithCovariance& message) {
  const Eigen::Vector3d ahead = rotation(message.pose.orientation) * Eigen::Vector3d::UnitX();
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << message.pose.position.x << " " << message.pose.position.y << " "
       << std::atan2(ahead.y(), ahead.x()) << " "
       << std::sqrt(std::max(message.covariance[0], message.covariance[7]));
  return {time, name_of(CommandName::kLocateAt), text.str()};
}

// Fills all but the stamp. `frame` is that of the estimate: odom or map. The variance of the turn
// rate is not known (0).
template <class Odometry>
void fill(Odometry& m, const OdometryEstimate& estimate, const std::string& frame,
          const std::string& body) {
  m.header.frame_id = frame;
  m.child_frame_id = body;
  copy(estimate.p_odom_body, m.pose.pose.position);
  copy(estimate.q_odom_body, m.pose.pose.orientation);
  copy(estimate.v_body, m.twist.twist.linear);
  copy(estimate.omega_body, m.twist.twist.angular);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      m.pose.covariance[6 * row + column] = estimate.pose_covariance(row, column);
      if (row < 3 && column < 3)
        m.twist.covariance[6 * row + column] = estimate.velocity_covariance(row, column);
    }
  }
}

// Fills all but the stamp of a TransformStamped: the pose of `child` in `parent`.
template <class Transform>
void fill(Transform& t, const std::string& parent, const std::string& child,
          const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation) {
  t.header.frame_id = parent;
  t.child_frame_id = child;
  copy(position, t.transform.translation);
  copy(orientation, t.transform.rotation);
}

// map -> odom and odom -> body, from one pose in map and in odom.
template <class Transform, class Stamp>
std::vector<Transform> transforms(const Stamp& stamp, const OdometryEstimate& in_odom,
                                  const OdometryEstimate& in_map, const FrameNames& frames) {
  const Eigen::Quaterniond q_map_odom =
      (in_map.q_odom_body * in_odom.q_odom_body.conjugate()).normalized();
  std::vector<Transform> both(2);
  for (Transform& t : both) t.header.stamp = stamp;
  fill(both[0], frames.map, frames.odom, in_map.p_odom_body - q_map_odom * in_odom.p_odom_body,
       q_map_odom);
  fill(both[1], frames.odom, frames.body, in_odom.p_odom_body, in_odom.q_odom_body);
  return both;
}

template <class DiagnosticStatus>
void add_value(DiagnosticStatus& s, const std::string& key, double value) {
  char text[32];  // the shortest that reads back as the same number takes at most 24
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  s.values.emplace_back();
  s.values.back().key = key;
  s.values.back().value.assign(text, end);
}

template <class DiagnosticArray, class Stamp>
DiagnosticArray diagnostics(const Stamp& stamp, const Status& status) {
  DiagnosticArray array;
  array.header.stamp = stamp;
  array.status.emplace_back();
  auto& s = array.status.back();
  using Level = std::decay_t<decltype(s)>;
  s.level = status.health == HealthLevel::kOk         ? Level::OK
            : status.health == HealthLevel::kDegraded ? Level::WARN
                                                      : Level::ERROR;
  s.name = "gprodom: odometry";
  s.hardware_id = "gprodom";
  for (const auto& reason : status.reasons) s.message += (s.message.empty() ? "" : "; ") + reason;
  if (s.message.empty()) s.message = "ok";
  for (std::size_t i = 0; i < status.names.size() && i < status.values.size(); ++i)
    add_value(s, status.names[i], status.values[i]);
  return array;
}

}  // namespace gprodom::ros_shared
