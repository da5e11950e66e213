// The estimator as a ROS 1 node: sensor topics in, odometry, tf and diagnostics out.
#pragma once

#include <gprodom_ros/GprTrace.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Int64.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_broadcaster.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/live.h"
#include "ros1_io.h"

namespace gprodom {

class RosNode {
 public:
  // Parameters are read from the private name space. Throws ConfigError, or std::runtime_error
  // where a parameter cannot be used.
  RosNode();

 private:
  template <class Message>
  void on(const std::string& topic, std::function<void(const Message&)> take);
  void subscribe();
  void subscribe_joints(double radius_m);
  void subscribe_ticks(double metres_per_tick);
  void serve(const std::string& name, const std::string& argument);  // the command of this name
  void command(const std::string& name, const std::string& argument,
               std_srvs::Trigger::Response& response);
  void publish(const Outputs& outputs);

  ros::NodeHandle topics_, private_;
  ros1::FrameNames frames_;
  bool publish_tf_ = true;

  // Used by the thread that spins.
  ros1::WheelOdometry wheel_;
  std::optional<ros1::WheelsOdometry> wheels_;
  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;

  // Used by the publish thread.
  ros::Publisher odometry_, odometry_map_, diagnostics_;
  tf2_ros::TransformBroadcaster transforms_;

  std::unique_ptr<Live> live_;  // last: its threads use what is above
};

}  // namespace gprodom
