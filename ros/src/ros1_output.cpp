#include "ros1_io.h"

namespace gprodom::ros1 {

ros::Time to_stamp(TimeNs time) {
  ros::Time stamp;
  stamp.fromNSec(static_cast<std::uint64_t>(time));
  return stamp;
}

nav_msgs::Odometry to_odometry(const OdometryEstimate& estimate, const std::string& frame,
                               const std::string& body) {
  nav_msgs::Odometry m;
  m.header.stamp = to_stamp(estimate.time);
  ros_shared::fill(m, estimate, frame, body);
  return m;
}

geometry_msgs::TransformStamped to_transform(const OdometryEstimate& in_odom,
                                             const FrameNames& frames) {
  geometry_msgs::TransformStamped t;
  t.header.stamp = to_stamp(in_odom.time);
  ros_shared::fill(t, in_odom, frames);
  return t;
}

geometry_msgs::TransformStamped to_transform(const OdometryEstimate& in_odom,
                                             const OdometryEstimate& in_map,
                                             const FrameNames& frames) {
  geometry_msgs::TransformStamped t;
  t.header.stamp = to_stamp(in_odom.time);
  ros_shared::fill(t, in_odom, in_map, frames);
  return t;
}

diagnostic_msgs::DiagnosticArray to_diagnostics(const Status& status, const std::string& name) {
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = to_stamp(status.time);
  array.status.emplace_back();
  ros_shared::fill(array.status.back(), status, name);
  return array;
}

}  // namespace gprodom::ros1
