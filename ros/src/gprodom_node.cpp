// gprodom_node: the estimator as a ROS 1 node.
#include <ros/ros.h>

#include <exception>

#include "ros_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "gprodom");
  try {
    const gprodom::RosNode node;
    ros::spin();
    return 0;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
}
