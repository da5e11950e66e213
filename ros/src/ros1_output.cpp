#include <boost/lexical_cast.hpp>

#include "ros1_io.h"

namespace gprodom::ros1 {
namespace {

template <class Message>  // geometry_msgs::Vector3 or Point
void copy(const Eigen::Vector3d& from, Message& to) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

void copy(const Eigen::Quaterniond& from, geometry_msgs::Quaternion& to) {
  to.w = from.w();
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

}  // namespace

ros::Time to_stamp(TimeNs time) {
  ros::Time stamp;
  stamp.fromNSec(static_cast<std::uint64_t>(time));
  return stamp;
}

nav_msgs::Odometry to_odometry(const OdometryEstimate& estimate, const std::string& frame,
                               const std::string& body) {
  nav_msgs::Odometry m;
  m.header.stamp = to_stamp(estimate.time);
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
  return m;
}

geometry_msgs::TransformStamped to_transform(const OdometryEstimate& in_odom,
                                             const FrameNames& frames) {
  geometry_msgs::TransformStamped t;
  t.header.stamp = to_stamp(in_odom.time);
  t.header.frame_id = frames.odom;
  t.child_frame_id = frames.body;
  copy(in_odom.p_odom_body, t.transform.translation);
  copy(in_odom.q_odom_body, t.transform.rotation);
  return t;
}

geometry_msgs::TransformStamped to_transform(const OdometryEstimate& in_odom,
                                             const OdometryEstimate& in_map,
                                             const FrameNames& frames) {
  const Eigen::Quaterniond q_map_odom =
      (in_map.q_odom_body * in_odom.q_odom_body.conjugate()).normalized();
  geometry_msgs::TransformStamped t;
  t.header.stamp = to_stamp(in_odom.time);
  t.header.frame_id = frames.map;
  t.child_frame_id = frames.odom;
  const Eigen::Vector3d p_map_odom = in_map.p_odom_body - q_map_odom * in_odom.p_odom_body;
  copy(p_map_odom, t.transform.translation);
  copy(q_map_odom, t.transform.rotation);
  return t;
}

diagnostic_msgs::DiagnosticArray to_diagnostics(const Status& status, const std::string& name) {
  diagnostic_msgs::DiagnosticStatus s;
  s.level = status.health == HealthLevel::kOk         ? diagnostic_msgs::DiagnosticStatus::OK
            : status.health == HealthLevel::kDegraded ? diagnostic_msgs::DiagnosticStatus::WARN
                                                      : diagnostic_msgs::DiagnosticStatus::ERROR;
  s.name = name;
  s.hardware_id = "gprodom";
  for (const auto& reason : status.reasons) s.message += (s.message.empty() ? "" : "; ") + reason;
  if (s.message.empty()) s.message = "ok";
  for (std::size_t i = 0; i < status.names.size() && i < status.values.size(); ++i) {
    diagnostic_msgs::KeyValue value;
    value.key = status.names[i];
    value.value = boost::lexical_cast<std::string>(status.values[i]);
    s.values.push_back(value);
  }
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = to_stamp(status.time);
  array.status.push_back(s);
  return array;
}

}  // namespace gprodom::ros1
