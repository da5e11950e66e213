// The estimator as a ROS 1 node: sensor topics in, odometry, tf and diagnostics out.
#pragma once

#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <string>
#include <vector>

#include "conversions.h"
#include "gprodom/live.h"
#include "wheels.h"

namespace gprodom {

class RosNode {
 public:
  // Parameters are read from the private name space. Throws ConfigError, or std::runtime_error
  // where a parameter cannot be used.
  RosNode();

 private:
  template <class Message, class ToInput>
  void on(const std::string& topic, ToInput to_input);
  void subscribe();
  void subscribe_wheel();
  void subscribe_ticks(double metres_per_tick);
  void serve(const std::string& name, const std::string& argument);  // the command of this name
  void command(const std::string& name, const std::string& argument,
               std_srvs::Trigger::Response& response);
  void publish(const Outputs& outputs);

  ros::NodeHandle topics_, private_;
  ros_shared::FrameNames frames_;
  bool publish_tf_ = true;

  // Used by the thread that spins.
  ros_shared::WheelOdometry wheel_;
  ros_shared::Integral turned_;
  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;

  // Used by the publish thread.
  ros::Publisher odometry_, odometry_map_, diagnostics_;
  tf2_ros::TransformBroadcaster transforms_;

  std::unique_ptr<Live> live_;  // last: its threads use what is above
};

}  // namespace gprodom
