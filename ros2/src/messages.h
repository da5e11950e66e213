// The ROS 2 messages that gprodom_ros2 takes and gives: fields and their order as in the public
// definitions of their packages (ros2/idl/messages.idl says the same in IDL), which is all that CDR
// knows of a message. `fields` hands them, in order, to a reader or a writer (cdr.h).
// kType is the name that ROS 2 gives the type on the wire; GPRODOM_MESSAGE is given it and the
// fields.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

// clang-format off
#define GPRODOM_MESSAGE(type, ...) \
  static constexpr char kType[] = type; \
  template <class Self, class Visitor> \
  static void fields(Self& m, Visitor& visit) { visit_in_order(visit, __VA_ARGS__); }
// clang-format on

namespace gprodom::ros2 {

template <class Visitor, class... Fields>
void visit_in_order(Visitor& visit, Fields&... fields) {
  (visit(fields), ...);
}

struct Time {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  GPRODOM_MESSAGE("builtin_interfaces::msg::dds_::Time_", m.sec, m.nanosec)
};

struct Header {
  Time stamp;
  std::string frame_id;
  GPRODOM_MESSAGE("std_msgs::msg::dds_::Header_", m.stamp, m.frame_id)
};

struct Int64 {
  std::int64_t data = 0;
  GPRODOM_MESSAGE("std_msgs::msg::dds_::Int64_", m.data)
};

struct Clock {
  Time clock;
  GPRODOM_MESSAGE("rosgraph_msgs::msg::dds_::Clock_", m.clock)
};

struct Log {
  enum : std::uint8_t { INFO = 20, WARN = 30 };
  Time stamp;
  std::uint8_t level = INFO;
  std::string name, msg, file, function;
  std::uint32_t line = 0;
  GPRODOM_MESSAGE("rcl_interfaces::msg::dds_::Log_", m.stamp, m.level, m.name, m.msg, m.file,
                  m.function, m.line)
};

// Also geometry_msgs/Point, which has the same fields.
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::Vector3_", m.x, m.y, m.z)
};

struct Quaternion {
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::Quaternion_", m.x, m.y, m.z, m.w)
};

struct Pose {
  Vector3 position;
  Quaternion orientation;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::Pose_", m.position, m.orientation)
};

struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance{};
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::PoseWithCovariance_", m.pose, m.covariance)
};

struct PoseWithCovarianceStamped {
  Header header;
  PoseWithCovariance pose;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::PoseWithCovarianceStamped_", m.header, m.pose)
};

struct Twist {
  Vector3 linear, angular;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::Twist_", m.linear, m.angular)
};

struct TwistStamped {
  Header header;
  Twist twist;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::TwistStamped_", m.header, m.twist)
};

struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance{};
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::TwistWithCovariance_", m.twist, m.covariance)
};

struct Transform {
  Vector3 translation;
  Quaternion rotation;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::Transform_", m.translation, m.rotation)
};

struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Transform transform;
  GPRODOM_MESSAGE("geometry_msgs::msg::dds_::TransformStamped_", m.header, m.child_frame_id,
                  m.transform)
};

struct TFMessage {
  std::vector<TransformStamped> transforms;
  GPRODOM_MESSAGE("tf2_msgs::msg::dds_::TFMessage_", m.transforms)
};

struct Odometry {
  Header header;
  std::string child_frame_id;
  PoseWithCovariance pose;
  TwistWithCovariance twist;
  GPRODOM_MESSAGE("nav_msgs::msg::dds_::Odometry_", m.header, m.child_frame_id, m.pose, m.twist)
};

struct Imu {
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance{};
  GPRODOM_MESSAGE("sensor_msgs::msg::dds_::Imu_", m.header, m.orientation, m.orientation_covariance,
                  m.angular_velocity, m.angular_velocity_covariance, m.linear_acceleration,
                  m.linear_acceleration_covariance)
};

struct NavSatStatus {
  std::int8_t status = -1;
  std::uint16_t service = 0;
  GPRODOM_MESSAGE("sensor_msgs::msg::dds_::NavSatStatus_", m.status, m.service)
};

struct NavSatFix {
  Header header;
  NavSatStatus status;
  double latitude = 0.0, longitude = 0.0, altitude = 0.0;
  std::array<double, 9> position_covariance{};
  std::uint8_t position_covariance_type = 0;
  GPRODOM_MESSAGE("sensor_msgs::msg::dds_::NavSatFix_", m.header, m.status, m.latitude, m.longitude,
                  m.altitude, m.position_covariance, m.position_covariance_type)
};

struct JointState {
  Header header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
  GPRODOM_MESSAGE("sensor_msgs::msg::dds_::JointState_", m.header, m.name, m.position, m.velocity,
                  m.effort)
};

struct KeyValue {
  std::string key, value;
  GPRODOM_MESSAGE("diagnostic_msgs::msg::dds_::KeyValue_", m.key, m.value)
};

struct DiagnosticStatus {
  enum : std::uint8_t { OK = 0, WARN = 1, ERROR = 2 };
  std::uint8_t level = OK;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
  GPRODOM_MESSAGE("diagnostic_msgs::msg::dds_::DiagnosticStatus_", m.level, m.name, m.message,
                  m.hardware_id, m.values)
};

struct DiagnosticArray {
  Header header;
  std::vector<DiagnosticStatus> status;
  GPRODOM_MESSAGE("diagnostic_msgs::msg::dds_::DiagnosticArray_", m.header, m.status)
};

// ros2/gprodom_msgs/msg says what the fields of the next three mean.
struct GprTraceMessage {
  Header header;
  std::int64_t trace = 0;
  std::int32_t antenna_id = 0;
  double sample_interval = 0.0, time_zero = 0.0, volts_per_count = 0.0;
  std::vector<std::int32_t> samples;
  GPRODOM_MESSAGE("gprodom_msgs::msg::dds_::GprTrace_", m.header, m.trace, m.antenna_id,
                  m.sample_interval, m.time_zero, m.volts_per_count, m.samples)
};

struct Revisit {
  Header header;
  Time stamp_from, stamp_to;
  std::string source;
  double distance = 0.0, sigma = 0.0, lateral = 0.0, lateral_sigma = 0.0;
  bool mirrored = false;
  double score = 0.0;
  GPRODOM_MESSAGE("gprodom_msgs::msg::dds_::Revisit_", m.header, m.stamp_from, m.stamp_to, m.source,
                  m.distance, m.sigma, m.lateral, m.lateral_sigma, m.mirrored, m.score)
};

struct CommandMessage {
  std::string name, argument;
  GPRODOM_MESSAGE("gprodom_msgs::msg::dds_::Command_", m.name, m.argument)
};

}  // namespace gprodom::ros2

#undef GPRODOM_MESSAGE
