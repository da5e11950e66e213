#include "ros_node.h"

#include <stdexcept>

#include "gprodom/config.h"

namespace gprodom {
namespace {

// Bursts, such as a bag played fast, are queued rather than dropped.
constexpr std::uint32_t kQueue = 10000;

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

// Subscribes to `topic`; `take` is called on the thread that spins.
template <class Message>
void RosNode::on(const std::string& topic, std::function<void(const Message&)> take) {
  subscribers_.push_back(topics_.subscribe<Message>(
      topic, kQueue, [take](const boost::shared_ptr<const Message>& message) { take(*message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

void RosNode::subscribe() {
  on<sensor_msgs::Imu>("imu", [this](const auto& m) { live_->push(ros1::to_sample(m)); });
  on<gprodom_ros::GprTrace>("gpr", [this](const auto& m) { live_->push(ros1::to_trace(m)); });
  on<sensor_msgs::NavSatFix>("fix", [this](const auto& m) { live_->push(ros1::to_fix(m)); });
  on<geometry_msgs::PoseWithCovarianceStamped>(
      "site_pose", [this](const auto& m) { live_->push(ros1::to_fix(m)); });
  on<geometry_msgs::PoseWithCovarianceStamped>("initialpose", [this](const auto& m) {
    const std::string& frame = m.header.frame_id;
    if (frame == frames_.map || frame == "/" + frames_.map)
      live_->push(ros1::to_command(m));
    else
      ROS_WARN_STREAM("initialpose: not used: it is in frame '" << frame << "', expected '"
                                                                << frames_.map << "'");
  });
  const auto wheel = private_.param<std::string>("wheel", "odometry");
  const auto track_m = private_.param<double>("track", 0.0);
  if (wheel == "odometry" && track_m > 0.0) {
    wheels_.emplace(track_m);
    on<nav_msgs::Odometry>("wheel_odometry",
                           [this](const auto& m) { live_->push(wheels_->add(m)); });
  } else if (wheel == "odometry") {
    on<nav_msgs::Odometry>("wheel_odometry", [this](const auto& m) { live_->push(wheel_.add(m)); });
  } else if (wheel == "joint") {
    const auto joint = private_.param<std::string>("wheel_joint", "");
    if (joint.empty()) throw std::runtime_error("parameter ~wheel_joint: expected a joint's name");
    const double radius_m = positive(private_, "wheel_radius");
    on<sensor_msgs::JointState>("joint_states", [this, joint, radius_m](const auto& m) {
      if (const auto sample = ros_shared::to_sample(ros1::to_ns(m.header.stamp), m.name, m.position,
                                                    joint, radius_m))
        live_->push(*sample);
    });
  } else if (wheel == "joints") {
    subscribe_joints(positive(private_, "wheel_radius"));
  } else if (wheel == "ticks") {
    subscribe_ticks(positive(private_, "metres_per_tick"));
  } else if (wheel != "none") {
    throw std::runtime_error(
        "parameter ~wheel: expected odometry, joint, joints, ticks or none, got " + wheel);
  }
}

void RosNode::subscribe_joints(double radius_m) {
  const auto left = joints(private_, "left_joints"), right = joints(private_, "right_joints");
  on<sensor_msgs::JointState>("joint_states", [this, left, right, radius_m](const auto& m) {
    if (const auto sample = ros_shared::to_sample(ros1::to_ns(m.header.stamp), m.name, m.position,
                                                  left, right, radius_m))
      live_->push(*sample);
  });
}

// This message alone has no stamp of its own. When it came in counts, not when its turn is.
void RosNode::subscribe_ticks(double metres_per_tick) {
  using Event = ros::MessageEvent<const std_msgs::Int64>;
  const boost::function<void(const Event&)> take = [this, metres_per_tick](const Event& event) {
    const auto ticks = static_cast<double>(event.getConstMessage()->data);
    live_->push(
        WheelSample{ros1::to_ns(event.getReceiptTime()), ticks * metres_per_tick, metres_per_tick});
  };
  subscribers_.push_back(topics_.subscribe<std_msgs::Int64, const Event&>(
      "wheel_ticks", kQueue, take, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

void RosNode::publish(const Outputs& outputs) {
  const auto& in_odom = outputs.odometry;
  const auto& in_map = outputs.odometry_in_map;
  for (std::size_t i = 0; i < in_odom.size(); ++i) {
    odometry_.publish(ros1::to_odometry(in_odom[i], frames_.odom, frames_.body));
    odometry_map_.publish(ros1::to_odometry(in_map[i], frames_.map, frames_.body));
    if (!publish_tf_) continue;
    transforms_.sendTransform({ros1::to_transform(in_odom[i], in_map[i], frames_),
                               ros1::to_transform(in_odom[i], frames_)});
  }
  for (const auto& warning : outputs.warnings) ROS_WARN_STREAM(warning);
  for (const auto& status : outputs.status) {
    diagnostics_.publish(ros1::to_diagnostics(status, "gprodom: odometry"));
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
