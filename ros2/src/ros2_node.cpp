#include "ros2_node.h"

#include <chrono>

#include "conversions.h"
#include "fixes.h"

namespace gprodom::ros2 {
namespace {

constexpr char kName[] = "gprodom";

TimeNs to_ns(const Time& stamp) { return stamp.sec * kSecond + stamp.nanosec; }

template <class Message>
TimeNs time_of(const Message& message) {
  return to_ns(message.header.stamp);
}

Time to_stamp(TimeNs time) {
  return {static_cast<std::int32_t>(time / kSecond), static_cast<std::uint32_t>(time % kSecond)};
}

template <class Clock>
std::int64_t ns_of() {
  return std::chrono::nanoseconds(Clock::now().time_since_epoch()).count();
}

Revisit to_revisit(const Displacement& d, const std::string& frame) {
  return {{to_stamp(d.time), frame},
          to_stamp(d.from),
          to_stamp(d.to),
          d.source,
          d.distance_m,
          d.sigma_m,
          d.lateral_m,
          d.lateral_sigma_m,
          d.mirrored,
          d.score};
}

// Warnings and counts of the estimator name the topic that a message came on.
Config with_topics(Config config, const Settings& settings) {
  config.channels.imu = settings.imu;
  config.channels.gpr_trace = settings.gpr;
  config.channels.wheel = config.channels.wheels = settings.wheel;
  config.channels.command = settings.command;
  config.channels.position_fix = settings.fix;
  return config;
}

}  // namespace

Ros2Node::Ros2Node(const Config& config, const Settings& settings, NodeHooks hooks)
    : settings_(settings),
      hooks_(std::move(hooks)),
      link_(settings, [this](const std::string& topic, const std::string& reason) {
        live_->push(Rejection{topic, reason});
      }) {
  odometry_ = link_.publish<Odometry>(settings.odometry, out());
  odometry_map_ = link_.publish<Odometry>(settings.odometry_map, out());
  revisits_ = link_.publish<Revisit>(settings.revisits, out());
  diagnostics_ = link_.publish<DiagnosticArray>(settings.diagnostics, out());
  counts_ = diagnostics_;
  log_ = link_.publish<Log>("/rosout", {true, settings.depth, true});
  if (settings.publish_tf) tf_ = link_.publish<TFMessage>(settings.tf, out());
  if (!settings.gpr_frame.empty()) {
    tf_static_ = link_.publish<TFMessage>(settings.tf_static, {true, 1, true});
    publish_antennas(config.gpr);
  }
  LiveOptions options;
  options.alive = hooks_.alive;
  live_ = std::make_unique<Live>(
      with_topics(config, settings), [this](const Outputs& outputs) { publish(outputs); },
      std::move(options));
  subscribe();
}

void Ros2Node::receive() {
  link_.receive();
  const std::int64_t steady_ns = ns_of<std::chrono::steady_clock>();
  if (steady_ns < next_counts_ns_) return;
  next_counts_ns_ = steady_ns + kSecond;
  publish_counts();
}

// Subscribes to a sensor's topic; what `to_input` makes of a message goes to the estimator.
template <class Message, class ToInput>
void Ros2Node::on(const std::string& topic, ToInput to_input) {
  const Quality quality{settings_.sensors_reliable, settings_.sensor_depth, false};
  link_.subscribe<Message>(topic, quality, [this, to_input](const Message& m) {
    if (const std::optional<Input> input = to_input(m)) live_->push(*input);
  });
}

void Ros2Node::subscribe() {
  using ros_shared::to_fix, ros_shared::to_imu, ros_shared::to_trace;
  using StampedPose = PoseWithCovarianceStamped;
  on<Imu>(settings_.imu, [](const auto& m) { return to_imu(time_of(m), m); });
  on<GprTraceMessage>(settings_.gpr, [](const auto& m) { return to_trace(time_of(m), m); });
  on<NavSatFix>(settings_.fix, [](const auto& m) { return to_fix(time_of(m), m); });
  on<StampedPose>(settings_.site_pose,
                  [](const auto& m) { return ros_shared::to_site_fix(time_of(m), m.pose); });
  link_.subscribe<StampedPose>(settings_.initialpose, out(), [this](const StampedPose& m) {
    if (m.header.frame_id == settings_.frames.map)
      live_->push(ros_shared::to_locate_at(time_of(m), m.pose));
    else
      live_->push(Rejection{settings_.initialpose, "message is not in the frame of the map"});
  });
  link_.subscribe<CommandMessage>(settings_.command, out(), [this](const CommandMessage& m) {
    live_->push(Command{0, m.name, m.argument});
  });
  if (settings_.use_sim_time)
    link_.subscribe<Clock>("/clock", {false, 1, false},
                           [this](const Clock& m) { simulated_ = to_ns(m.clock); });
  subscribe_wheel();
}

void Ros2Node::subscribe_wheel() {
  const double radius_m = settings_.wheel_radius;
  switch (settings_.wheel_message) {
    case WheelMessage::kOdometry:
      on<Odometry>(settings_.wheel, [this](const Odometry& m) {
        const auto middle = wheel_.add(time_of(m), ros_shared::vector(m.pose.pose.position),
                                       ros_shared::rotation(m.pose.pose.orientation));
        return wheels_of(middle, m.twist.twist.angular.z);
      });
      break;
    case WheelMessage::kTwist:
      on<TwistStamped>(settings_.wheel, [this](const TwistStamped& m) {
        const double distance_m = distance_.add(time_of(m), m.twist.linear.x);
        return wheels_of({time_of(m), distance_m}, m.twist.angular.z);
      });
      break;
    case WheelMessage::kJoint:
      on<JointState>(settings_.wheel, [this, radius_m](const JointState& m) {
        return ros_shared::to_sample(time_of(m), m.name, m.position, settings_.wheel_joint,
                                     radius_m);
      });
      break;
    case WheelMessage::kJoints:
      on<JointState>(settings_.wheel,
                     [radius_m, left = ros_shared::names_by_commas(settings_.left_joints),
                      right = ros_shared::names_by_commas(settings_.right_joints)](const auto& m) {
                       return ros_shared::to_sample(time_of(m), m.name, m.position, left, right,
                                                    radius_m);
                     });
      break;
    case WheelMessage::kTicks:
      on<Int64>(settings_.wheel, [this](const Int64& m) {
        const double metres_per_tick = settings_.metres_per_tick;
        return WheelSample{now(), static_cast<double>(m.data) * metres_per_tick, metres_per_tick};
      });
      break;
    case WheelMessage::kNone:
      break;
  }
}

Input Ros2Node::wheels_of(const WheelSample& middle, double yaw_rate) {
  if (!(settings_.track > 0.0)) return middle;
  return ros_shared::to_wheels(middle, turned_.add(middle.time, yaw_rate), settings_.track);
}

TimeNs Ros2Node::now() const {
  return settings_.use_sim_time ? simulated_.load() : ns_of<std::chrono::system_clock>();
}

void Ros2Node::publish(const Outputs& outputs) {
  const auto& in_odom = outputs.odometry;
  const auto& in_map = outputs.odometry_in_map;
  const auto& frames = settings_.frames;
  for (std::size_t i = 0; i < in_odom.size(); ++i) {
    Odometry m;
    m.header.stamp = to_stamp(in_odom[i].time);
    ros_shared::fill(m, in_odom[i], frames.odom, frames.body);
    odometry_(m);
    ros_shared::fill(m, in_map[i], frames.map, frames.body);
    odometry_map_(m);
    tf_(TFMessage{
        ros_shared::transforms<TransformStamped>(m.header.stamp, in_odom[i], in_map[i], frames)});
  }
  for (const auto& d : outputs.displacements)
    if (d.kind == DisplacementKind::kRevisit && d.valid) revisits_(to_revisit(d, frames.body));
  for (const auto& warning : outputs.warnings) {
    hooks_.warning(warning);
    log_(Log{to_stamp(ns_of<std::chrono::system_clock>()), Log::WARN, kName, warning, "", "", 0});
  }
  for (const auto& status : outputs.status) {
    diagnostics_(ros_shared::diagnostics<DiagnosticArray>(to_stamp(status.time), status));
    hooks_.status(status);
  }
}

// base_link -> antennas, once and for all. A further one's frame has its id: gpr_antenna_1.
void Ros2Node::publish_antennas(const GprConfig& gpr) {
  TFMessage m;
  const auto add = [&](const std::string& frame, const Eigen::Vector3d& place) {
    m.transforms.emplace_back();
    m.transforms.back().header.stamp = to_stamp(now());
    ros_shared::fill(m.transforms.back(), settings_.frames.body, frame, place,
                     Eigen::Quaterniond::Identity());
  };
  add(settings_.gpr_frame, gpr.lever_arm);  // of the first in gpr.antennas, where there are any
  for (const auto& [id, place] : gpr.antennas)
    if (id != gpr.antennas.begin()->first)
      add(settings_.gpr_frame + "_" + std::to_string(id), place);
  tf_static_(m);
}

// What came over each topic and what did not.
void Ros2Node::publish_counts() {
  DiagnosticStatus s;
  s.name = "gprodom: ROS 2";
  s.hardware_id = kName;
  for (const auto& [topic, counts] : link_.counts()) {
    const auto add = [&, &topic = topic](const char* what, std::uint64_t count) {
      ros_shared::add_value(s, topic + ": " + what, static_cast<double>(count));
    };
    add("publishers", counts.publishers);
    add("received", counts.received);
    add("refused", counts.refused);
    add("lost", counts.lost);
    add("publishers of other quality of service", counts.incompatible);
    add("publishers of another type", counts.other_types);
    if (counts.incompatible + counts.other_types + counts.refused > 0) {
      s.level = DiagnosticStatus::WARN;
      s.message += (s.message.empty() ? "" : "; ") + topic + ": not all of it can be used";
    }
  }
  const auto unsent = odometry_.unsent() + odometry_map_.unsent() + tf_.unsent();
  ros_shared::add_value(s, "poses not sent", static_cast<double>(unsent));
  if (s.message.empty()) s.message = "ok";
  DiagnosticArray array;
  array.header.stamp = to_stamp(now());
  array.status.push_back(std::move(s));
  counts_(array);
}

}  // namespace gprodom::ros2
