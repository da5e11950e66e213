#include "fixes.h"
#include "ros1_io.h"

namespace gprodom::ros1 {

TimeNs to_ns(const ros::Time& stamp) {
  return static_cast<TimeNs>(stamp.sec) * 1'000'000'000 + stamp.nsec;
}

ImuSample to_sample(const sensor_msgs::Imu& message) {
  return ros_shared::to_imu(to_ns(message.header.stamp), message);
}

GprTrace to_trace(const gprodom_ros::GprTrace& message) {
  return ros_shared::to_trace(to_ns(message.header.stamp), message);
}

PositionFix to_fix(const sensor_msgs::NavSatFix& message) {
  return ros_shared::to_fix(to_ns(message.header.stamp), message);
}

PositionFix to_fix(const geometry_msgs::PoseWithCovarianceStamped& message) {
  return ros_shared::to_site_fix(to_ns(message.header.stamp), message.pose);
}

Command to_command(const geometry_msgs::PoseWithCovarianceStamped& message) {
  return ros_shared::to_locate_at(to_ns(message.header.stamp), message.pose);
}

WheelSample WheelOdometry::add(const nav_msgs::Odometry& message) {
  const geometry_msgs::Pose& pose = message.pose.pose;
  return distance_.add(to_ns(message.header.stamp), ros_shared::vector(pose.position),
                       ros_shared::rotation(pose.orientation));
}

WheelsSample WheelsOdometry::add(const nav_msgs::Odometry& message) {
  const WheelSample middle = middle_.add(message);
  const double turned_rad = turned_.add(middle.time, message.twist.twist.angular.z);
  return ros_shared::to_wheels(middle, turned_rad, track_m_);
}

}  // namespace gprodom::ros1
