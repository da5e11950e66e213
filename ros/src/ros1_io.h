// ROS 1 messages to measurements, and estimates to ROS 1 messages. What does not depend on the
// version of ROS is in ros/shared/.
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <gprodom_ros/GprTrace.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/NavSatFix.h>

#include <optional>
#include <string>
#include <vector>

#include "conversions.h"
#include "gprodom/input.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"
#include "wheels.h"

namespace gprodom::ros1 {

using ros_shared::FrameNames;

TimeNs to_ns(const ros::Time& stamp);
ros::Time to_stamp(TimeNs time);

ImuSample to_sample(const sensor_msgs::Imu& message);
GprTrace to_trace(const gprodom_ros::GprTrace& message);
PositionFix to_fix(const sensor_msgs::NavSatFix& message);                    // geodetic
PositionFix to_fix(const geometry_msgs::PoseWithCovarianceStamped& message);  // in site
Command to_command(const geometry_msgs::PoseWithCovarianceStamped& message);

// The wheel's distance from the poses that its driver integrates.
class WheelOdometry {
 public:
  WheelSample add(const nav_msgs::Odometry& message);

 private:
  ros_shared::WheelOdometry distance_;
};

// The same for left and right wheels, track_m apart: the integral of the twist's yaw rate gives
// their difference.
class WheelsOdometry {
 public:
  explicit WheelsOdometry(double track_m) : track_m_(track_m) {}
  WheelsSample add(const nav_msgs::Odometry& message);

 private:
  WheelOdometry middle_;
  ros_shared::Integral turned_;
  double track_m_;
};

nav_msgs::Odometry to_odometry(const OdometryEstimate& estimate, const std::string& frame,
                               const std::string& body);

// odom -> body.
geometry_msgs::TransformStamped to_transform(const OdometryEstimate& in_odom,
                                             const FrameNames& frames);

// map -> odom, from one pose in both.
geometry_msgs::TransformStamped to_transform(const OdometryEstimate& in_odom,
                                             const OdometryEstimate& in_map,
                                             const FrameNames& frames);

diagnostic_msgs::DiagnosticArray to_diagnostics(const Status& status, const std::string& name);

}  // namespace gprodom::ros1
