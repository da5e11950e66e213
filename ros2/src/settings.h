// The settings of gprodom_ros2 that the estimator knows nothing of: network, names, frames, and
// what the wheel's messages are. ros2/ros2.yaml has them all with their defaults.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "conversions.h"

namespace gprodom::ros2 {

enum class WheelMessage { kOdometry, kTwist, kJoint, kJoints, kTicks, kNone };
constexpr std::array<const char*, 6> names_like(WheelMessage) {
  return {"odometry", "twist", "joint", "joints", "ticks", "none"};
}

struct Settings {
  int domain = 0;
  std::string interface = "lo";
  std::string name_space = "/";

  std::string imu = "imu/data", gpr = "gpr", wheel = "wheel_odometry", fix = "fix",
              site_pose = "site_pose", initialpose = "initialpose", command = "gprodom/command";
  std::string odometry = "odometry", odometry_map = "odometry_map", revisits = "revisits",
              tf = "/tf", tf_static = "/tf_static", diagnostics = "/diagnostics";

  WheelMessage wheel_message = WheelMessage::kOdometry;
  std::string wheel_joint, left_joints, right_joints;  // names, the last two by commas
  double wheel_radius = 0.0;                           // m
  double track = 0.0;                                  // m
  double metres_per_tick = 0.0;

  ros_shared::FrameNames frames;
  std::string gpr_frame = "gpr_antenna";
  bool publish_tf = true;

  bool sensors_reliable = false;
  int sensor_depth = 10000;
  int depth = 1000;
  bool use_sim_time = false;
};

// Reads files of "name: value" over the defaults, later ones over earlier ones, then "name:=value"
// in order. Throws ConfigError ("file:line: name: what was expected"), also for unknown names and
// where settings do not go together.
Settings load_settings(const std::vector<std::string>& paths,
                       const std::vector<std::string>& values);

// All settings with their meaning: what ros2/ros2.yaml holds.
std::string describe(Settings settings);

// A topic's name on the wire: of ROS's name in its namespace, after "rt" as ROS 2 puts it.
std::string on_the_wire(const Settings& settings, const std::string& topic);

}  // namespace gprodom::ros2
