#include "ros_node.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <gprodom_ros/GprTrace.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/NavSatFix.h>
#include <std_msgs/Int64.h>

#include <stdexcept>

#include "fixes.h"

namespace gprodom {
namespace {

// Bursts, such as a bag played fast, are queued rather than dropped.
constexpr std::uint32_t kQueue = 10000;

TimeNs to_ns(const ros::Time& stamp) { return static_cast<TimeNs>(stamp.toNSec()); }

template <class Message>
TimeNs time_of(const Message& message) {
  return to_ns(message.header.stamp);
}

ros::Time to_stamp(TimeNs time) { return ros::Time().fromNSec(static_cast<std::uint64_t>(time)); }

// ~config: a file, or a list of them, later ones override earlier ones.
Config configuration(const ros::NodeHandle& parameters) {
  std::vector<std::string> paths;
  if (!parameters.getParam("config", paths)) {
    const auto path = parameters.param<std::string>("config", "");
    if (!path.empty()) paths.push_back(path);
  }
  return load_config(paths);
}

double positive(const ros::NodeHandle& parameters, const std::string& name) {
  double value = 0.0;
  if (!parameters.getParam(name, value) || !(value > 0.0)) {
    throw std::runtime_error("parameter ~" + name + ": expected a number above 0, in metres");
  }
  return value;
}

std::vector<std::string> joints(const ros::NodeHandle& parameters, const std::string& name) {
  auto found = ros_shared::names_by_commas(parameters.param<std::string>(name, ""));
  if (found.empty())
    throw std::runtime_error("parameter ~" + name + ": expected names of joints, by commas");
  return found;
}

}  // namespace

RosNode::RosNode() : private_("~") {
  private_.param("map_frame", frames_.map, frames_.map);
  private_.param("odom_frame", frames_.odom, frames_.odom);
  private_.param("base_frame", frames_.body, frames_.body);
  private_.param("publish_tf", publish_tf_, publish_tf_);
  odometry_ = topics_.advertise<nav_msgs::Odometry>("odometry", kQueue);
  odometry_map_ = topics_.advertise<nav_msgs::Odometry>("odometry_map", kQueue);
  diagnostics_ = topics_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  live_ = std::make_unique<Live>(configuration(private_),
                                 [this](const Outputs& outputs) { publish(outputs); });
  subscribe();
  serve(name_of(CommandName::kReset), "");
  serve(name_of(CommandName::kSaveMap), "saved");  // <state.directory>/saved.map
}

void RosNode::serve(const std::string& name, const std::string& argument) {
  using Request = std_srvs::Trigger::Request;
  using Response = std_srvs::Trigger::Response;
  const boost::function<bool(Request&, Response&)> answer = [this, name, argument](Request&,
                                                                                   Response& said) {
    command(name, argument, said);
    return true;
  };
  services_.push_back(private_.advertiseService(name, answer));
}

// Subscribes to `topic`; what `to_input` makes of a message goes to the estimator, on the thread
// that spins.
template <class Message, class ToInput>
void RosNode::on(const std::string& topic, ToInput to_input) {
  const auto take = [this, to_input](const boost::shared_ptr<const Message>& message) {
    if (const std::optional<Input> input = to_input(*message)) live_->push(*input);
  };
  subscribers_.push_back(topics_.subscribe<Message>(topic, kQueue, take, ros::VoidConstPtr(),
                                                    ros::TransportHints().tcpNoDelay()));
}

void RosNode::subscribe() {
  using ros_shared::to_fix, ros_shared::to_imu, ros_shared::to_trace;
  using Pose = geometry_msgs::PoseWithCovarianceStamped;
  on<sensor_msgs::Imu>("imu", [](const auto& m) { return to_imu(time_of(m), m); });
  on<gprodom_ros::GprTrace>("gpr", [](const auto& m) { return to_trace(time_of(m), m); });
  on<sensor_msgs::NavSatFix>("fix", [](const auto& m) { return to_fix(time_of(m), m); });
  on<Pose>("site_pose", [](const auto& m) { return ros_shared::to_site_fix(time_of(m), m.pose); });
  on<Pose>("initialpose", [this](const auto& m) -> std::optional<Input> {
    const std::string& frame = m.header.frame_id;
    if (frame == frames_.map || frame == "/" + frames_.map)
      return ros_shared::to_locate_at(time_of(m), m.pose);
    ROS_WARN_STREAM("initialpose: not used: it is in frame '" << frame << "', expected '"
                                                              << frames_.map << "'");
    return std::nullopt;
  });
  subscribe_wheel();
}

void RosNode::subscribe_wheel() {
  const auto wheel = private_.param<std::string>("wheel", "odometry");
  if (wheel == "odometry") {
    const auto track_m = private_.param<double>("track", 0.0);
    on<nav_msgs::Odometry>("wheel_odometry", [this, track_m](const auto& m) -> Input {
      const WheelSample middle = wheel_.add(time_of(m), ros_shared::vector(m.pose.pose.position),
                                            ros_shared::rotation(m.pose.pose.orientation));
      if (!(track_m > 0.0)) return middle;
      return ros_shared::to_wheels(middle, turned_.add(middle.time, m.twist.twist.angular.z),
                                   track_m);
    });
  } else if (wheel == "joint") {
    const auto joint = private_.param<std::string>("wheel_joint", "");
    if (joint.empty()) throw std::runtime_error("parameter ~wheel_joint: expected a joint's name");
    const double radius_m = positive(private_, "wheel_radius");
    on<sensor_msgs::JointState>("joint_states", [joint, radius_m](const auto& m) {
      return ros_shared::to_sample(time_of(m), m.name, m.position, joint, radius_m);
    });
  } else if (wheel == "joints") {
    const double radius_m = positive(private_, "wheel_radius");
    const auto left = joints(private_, "left_joints"), right = joints(private_, "right_joints");
    on<sensor_msgs::JointState>("joint_states", [left, right, radius_m](const auto& m) {
      return ros_shared::to_sample(time_of(m), m.name, m.position, left, right, radius_m);
    });
  } else if (wheel == "ticks") {
    subscribe_ticks(positive(private_, "metres_per_tick"));
  } else if (wheel != "none") {
    throw std::runtime_error(
        "parameter ~wheel: expected odometry, joint, joints, ticks or none, got " + wheel);
  }
}

// This message alone has no stamp of its own. When it came in counts, not when its turn is.
void RosNode::subscribe_ticks(double metres_per_tick) {
  using Event = ros::MessageEvent<const std_msgs::Int64>;
  const boost::function<void(const Event&)> take = [this, metres_per_tick](const Event& event) {
    const auto ticks = static_cast<double>(event.getConstMessage()->data);
    live_->push(
        WheelSample{to_ns(event.getReceiptTime()), ticks * metres_per_tick, metres_per_tick});
  };
  subscribers_.push_back(topics_.subscribe<std_msgs::Int64, const Event&>(
      "wheel_ticks", kQueue, take, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

void RosNode::publish(const Outputs& outputs) {
  const auto& in_odom = outputs.odometry;
  const auto& in_map = outputs.odometry_in_map;
  for (std::size_t i = 0; i < in_odom.size(); ++i) {
    nav_msgs::Odometry m;
    m.header.stamp = to_stamp(in_odom[i].time);
    ros_shared::fill(m, in_odom[i], frames_.odom, frames_.body);
    odometry_.publish(m);
    ros_shared::fill(m, in_map[i], frames_.map, frames_.body);
    odometry_map_.publish(m);
    if (publish_tf_)
      transforms_.sendTransform(ros_shared::transforms<geometry_msgs::TransformStamped>(
          m.header.stamp, in_odom[i], in_map[i], frames_));
  }
  for (const auto& warning : outputs.warnings) ROS_WARN_STREAM(warning);
  for (const auto& status : outputs.status) {
    diagnostics_.publish(
        ros_shared::diagnostics<diagnostic_msgs::DiagnosticArray>(to_stamp(status.time), status));
  }
}

void RosNode::command(const std::string& name, const std::string& argument,
                      std_srvs::Trigger::Response& response) {
  Command command;
  command.name = name;
  command.argument = argument;
  live_->push(command);
  response.success = 1;
  response.message = name + " is asked of the estimator; what comes of it is in the log";
}

}  // namespace gprodom
