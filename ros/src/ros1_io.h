// ROS 1 messages to measurements, and estimates to ROS 1 messages; nothing else. Stamps are data
// time: nothing here asks for now.
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <gprodom_ros/GprTrace.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Int64.h>

#include <optional>
#include <string>
#include <vector>

#include "gprodom/input.h"
#include "gprodom/types.h"

namespace gprodom::ros1 {

TimeNs to_ns(const ros::Time& stamp);
ros::Time to_stamp(TimeNs time);

ImuSample to_sample(const sensor_msgs::Imu& message);
GprTrace to_trace(const gprodom_ros::GprTrace& message);

// The command locate_at, with the larger of the standard deviations of x and y.
Command to_command(const geometry_msgs::PoseWithCovarianceStamped& message);

// The wheel's distance from the poses that its driver integrates: the chord of each step, projected
// on the heading halfway.
class WheelOdometry {
 public:
  WheelSample add(const nav_msgs::Odometry& message);

 private:
  std::optional<geometry_msgs::Pose> last_;
  double distance_m_ = 0.0;
};

// The same for left and right wheels, track_m apart: the integral of the twist's yaw rate gives
// their difference.
class WheelsOdometry {
 public:
  explicit WheelsOdometry(double track_m) : track_m_(track_m) {}
  WheelsSample add(const nav_msgs::Odometry& message);

 private:
  WheelOdometry middle_;
  double track_m_, turned_rad_ = 0.0, rate_ = 0.0;
  TimeNs last_ = 0;
};

// The joint's angle (rad) times the wheel's radius (m); nothing if the message lacks the joint.
std::optional<WheelSample> to_sample(const sensor_msgs::JointState& message,
                                     const std::string& joint, double radius_m);

// The same of two sides, each the mean of its joints.
std::optional<WheelsSample> to_sample(const sensor_msgs::JointState& message,
                                      const std::vector<std::string>& left,
                                      const std::vector<std::string>& right, double radius_m);

struct FrameNames {
  std::string map = "map";
  std::string odom = "odom";
  std::string body = "base_link";
};

// `frame` is that of the estimate: odom or map. The variance of the turn rate is not known (0).
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
