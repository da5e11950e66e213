// The ROS 2 messages that gprodom_ros2 takes and gives: fields and their order as in the public
// definitions of their packages (ros2/idl/messages.idl says the same in IDL), which is all that CDR
// knows of a message. `fields` hands them, in order, to a reader or a writer (cdr.h).
// kType is the name that ROS 2 gives the type on the wire.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

// clang-format off
#define GPRODOM_FIELDS(...) \
  template <class Self, class Visitor> \
  static void fields(Self& m, Visitor& visit) { visit_in_order(m, visit, __VA_ARGS__); }
// clang-format on

namespace gprodom::ros2 {

template <class Message, class Visitor, class... Members>
void visit_in_order(Message& m, Visitor& visit, Members... members) {
  (visit(m.*members), ...);
}

struct Time {
  static constexpr char kType[] = "builtin_interfaces::msg::dds_::Time_";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  GPRODOM_FIELDS(&Time::sec, &Time::nanosec)
};

struct Header {
  static constexpr char kType[] = "std_msgs::msg::dds_::Header_";
  Time stamp;
  std::string frame_id;
  GPRODOM_FIELDS(&Header::stamp, &Header::frame_id)
};

struct Int64 {
  static constexpr char kType[] = "std_msgs::msg::dds_::Int64_";
  std::int64_t data = 0;
  GPRODOM_FIELDS(&Int64::data)
};

struct Clock {
  static constexpr char kType[] = "rosgraph_msgs::msg::dds_::Clock_";
  Time clock;
  GPRODOM_FIELDS(&Clock::clock)
};

struct Log {
  static constexpr char kType[] = "rcl_interfaces::msg::dds_::Log_";
  enum : std::uint8_t { INFO = 20, WARN = 30 };
  Time stamp;
  std::uint8_t level = INFO;
  std::string name, msg, file, function;
  std::uint32_t line = 0;
  GPRODOM_FIELDS(&Log::stamp, &Log::level, &Log::name, &Log::msg, &Log::file, &Log::function,
                 &Log::line)
};

// Also geometry_msgs/Point, which has the same fields.
struct Vector3 {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::Vector3_";
  double x = 0.0, y = 0.0, z = 0.0;
  GPRODOM_FIELDS(&Vector3::x, &Vector3::y, &Vector3::z)
};

struct Quaternion {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::Quaternion_";
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
  GPRODOM_FIELDS(&Quaternion::x, &Quaternion::y, &Quaternion::z, &Quaternion::w)
};

struct Pose {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::Pose_";
  Vector3 position;
  Quaternion orientation;
  GPRODOM_FIELDS(&Pose::position, &Pose::orientation)
};

struct PoseWithCovariance {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::PoseWithCovariance_";
  Pose pose;
  std::array<double, 36> covariance{};
  GPRODOM_FIELDS(&PoseWithCovariance::pose, &PoseWithCovariance::covariance)
};

struct PoseWithCovarianceStamped {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_";
  Header header;
  PoseWithCovariance pose;
  GPRODOM_FIELDS(&PoseWithCovarianceStamped::header, &PoseWithCovarianceStamped::pose)
};

struct Twist {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::Twist_";
  Vector3 linear, angular;
  GPRODOM_FIELDS(&Twist::linear, &Twist::angular)
};

struct TwistStamped {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::TwistStamped_";
  Header header;
  Twist twist;
  GPRODOM_FIELDS(&TwistStamped::header, &TwistStamped::twist)
};

struct TwistWithCovariance {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::TwistWithCovariance_";
  Twist twist;
  std::array<double, 36> covariance{};
  GPRODOM_FIELDS(&TwistWithCovariance::twist, &TwistWithCovariance::covariance)
};

struct Transform {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::Transform_";
  Vector3 translation;
  Quaternion rotation;
  GPRODOM_FIELDS(&Transform::translation, &Transform::rotation)
};

struct TransformStamped {
  static constexpr char kType[] = "geometry_msgs::msg::dds_::TransformStamped_";
  Header header;
  std::string child_frame_id;
  Transform transform;
  GPRODOM_FIELDS(&TransformStamped::header, &TransformStamped::child_frame_id,
                 &TransformStamped::transform)
};

struct TFMessage {
  static constexpr char kType[] = "tf2_msgs::msg::dds_::TFMessage_";
  std::vector<TransformStamped> transforms;
  GPRODOM_FIELDS(&TFMessage::transforms)
};

struct Odometry {
  static constexpr char kType[] = "nav_msgs::msg::dds_::Odometry_";
  Header header;
  std::string child_frame_id;
  PoseWithCovariance pose;
  TwistWithCovariance twist;
  GPRODOM_FIELDS(&Odometry::header, &Odometry::child_frame_id, &Odometry::pose, &Odometry::twist)
};

struct Imu {
  static constexpr char kType[] = "sensor_msgs::msg::dds_::Imu_";
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance{};
  GPRODOM_FIELDS(&Imu::header, &Imu::orientation, &Imu::orientation_covariance,
                 &Imu::angular_velocity, &Imu::angular_velocity_covariance,
                 &Imu::linear_acceleration, &Imu::linear_acceleration_covariance)
};

struct NavSatStatus {
  static constexpr char kType[] = "sensor_msgs::msg::dds_::NavSatStatus_";
  std::int8_t status = -1;
  std::uint16_t service = 0;
  GPRODOM_FIELDS(&NavSatStatus::status, &NavSatStatus::service)
};

struct NavSatFix {
  static constexpr char kType[] = "sensor_msgs::msg::dds_::NavSatFix_";
  Header header;
  NavSatStatus status;
  double latitude = 0.0, longitude = 0.0, altitude = 0.0;
  std::array<double, 9> position_covariance{};
  std::uint8_t position_covariance_type = 0;
  GPRODOM_FIELDS(&NavSatFix::header, &NavSatFix::status, &NavSatFix::latitude,
                 &NavSatFix::longitude, &NavSatFix::altitude, &NavSatFix::position_covariance,
                 &NavSatFix::position_covariance_type)
};

struct JointState {
  static constexpr char kType[] = "sensor_msgs::msg::dds_::JointState_";
  Header header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
  GPRODOM_FIELDS(&JointState::header, &JointState::name, &JointState::position,
                 &JointState::velocity, &JointState::effort)
};

struct KeyValue {
  static constexpr char kType[] = "diagnostic_msgs::msg::dds_::KeyValue_";
  std::string key, value;
  GPRODOM_FIELDS(&KeyValue::key, &KeyValue::value)
};

struct DiagnosticStatus {
  static constexpr char kType[] = "diagnostic_msgs::msg::dds_::DiagnosticStatus_";
  enum : std::uint8_t { OK = 0, WARN = 1, ERROR = 2 };
  std::uint8_t level = OK;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
  GPRODOM_FIELDS(&DiagnosticStatus::level, &DiagnosticStatus::name, &DiagnosticStatus::message,
                 &DiagnosticStatus::hardware_id, &DiagnosticStatus::values)
};

struct DiagnosticArray {
  static constexpr char kType[] = "diagnostic_msgs::msg::dds_::DiagnosticArray_";
  Header header;
  std::vector<DiagnosticStatus> status;
  GPRODOM_FIELDS(&DiagnosticArray::header, &DiagnosticArray::status)
};

// ros2/gprodom_msgs/msg says what the fields of the next three mean.
struct GprTraceMessage {
  static constexpr char kType[] = "gprodom_msgs::msg::dds_::GprTrace_";
  Header header;
  std::int64_t trace = 0;
  std::int32_t antenna_id = 0;
  double sample_interval = 0.0, time_zero = 0.0, volts_per_count = 0.0;
  std::vector<std::int32_t> samples;
  GPRODOM_FIELDS(&GprTraceMessage::header, &GprTraceMessage::trace, &GprTraceMessage::antenna_id,
                 &GprTraceMessage::sample_interval, &GprTraceMessage::time_zero,
                 &GprTraceMessage::volts_per_count, &GprTraceMessage::samples)
};

struct Revisit {
  static constexpr char kType[] = "gprodom_msgs::msg::dds_::Revisit_";
  Header header;
  Time stamp_from, stamp_to;
  std::string source;
  double distance = 0.0, sigma = 0.0, lateral = 0.0, lateral_sigma = 0.0;
  bool mirrored = false;
  double score = 0.0;
  GPRODOM_FIELDS(&Revisit::header, &Revisit::stamp_from, &Revisit::stamp_to, &Revisit::source,
                 &Revisit::distance, &Revisit::sigma, &Revisit::lateral, &Revisit::lateral_sigma,
                 &Revisit::mirrored, &Revisit::score)
};

struct CommandMessage {
  static constexpr char kType[] = "gprodom_msgs::msg::dds_::Command_";
  std::string name, argument;
  GPRODOM_FIELDS(&CommandMessage::name, &CommandMessage::argument)
};

}  // namespace gprodom::ros2

#undef GPRODOM_FIELDS
