#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

#include "ros1_io.h"

namespace gprodom::ros1 {
namespace {

Eigen::Vector3d vector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }
Eigen::Vector3d vector(const geometry_msgs::Point& p) { return {p.x, p.y, p.z}; }
Eigen::Quaterniond rotation(const geometry_msgs::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

}  // namespace

TimeNs to_ns(const ros::Time& stamp) {
  return static_cast<TimeNs>(stamp.sec) * 1'000'000'000 + stamp.nsec;
}

ImuSample to_sample(const sensor_msgs::Imu& message) {
  ImuSample sample;
  sample.time = to_ns(message.header.stamp);
  sample.acceleration = vector(message.linear_acceleration);
  sample.angular_velocity = vector(message.angular_velocity);
  return sample;
}

GprTrace to_trace(const gprodom_ros::GprTrace& message) {
  GprTrace trace;
  trace.time = to_ns(message.header.stamp);
  trace.seq = message.trace;
  trace.antenna_id = message.antenna_id;
  trace.sample_interval_s = message.sample_interval;
  trace.time_zero_s = message.time_zero;
  trace.volts_per_count = message.volts_per_count;
  trace.samples.assign(message.samples.begin(), message.samples.end());
  return trace;
}

Command to_command(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const geometry_msgs::Pose& pose = message.pose.pose;
  const Eigen::Vector3d ahead = rotation(pose.orientation) * Eigen::Vector3d::UnitX();
  const auto& covariance = message.pose.covariance;
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << pose.position.x << " " << pose.position.y << " " << std::atan2(ahead.y(), ahead.x())
       << " " << std::sqrt(std::max(covariance[0], covariance[7]));
  Command command;
  command.time = to_ns(message.header.stamp);
  command.name = name_of(CommandName::kLocateAt);
  command.argument = text.str();
  return command;
}

WheelSample WheelOdometry::add(const nav_msgs::Odometry& message) {
  const geometry_msgs::Pose& pose = message.pose.pose;
  if (last_) {
    const Eigen::Vector3d step = vector(pose.position) - vector(last_->position);
    if (!step.allFinite()) return {to_ns(message.header.stamp), step.sum()};  // refused later
    const Eigen::Quaterniond halfway =
        rotation(last_->orientation).slerp(0.5, rotation(pose.orientation));
    distance_m_ += std::copysign(step.norm(), step.dot(halfway * Eigen::Vector3d::UnitX()));
  }
  last_ = pose;
  return {to_ns(message.header.stamp), distance_m_};
}

WheelsSample WheelsOdometry::add(const nav_msgs::Odometry& message) {
  const WheelSample middle = middle_.add(message);
  const double rate = message.twist.twist.angular.z;
  if (last_ != 0) turned_rad_ += 0.5 * (rate_ + rate) * to_seconds(middle.time - last_);
  last_ = middle.time;
  rate_ = rate;
  const double half = 0.5 * track_m_ * turned_rad_;
  return {middle.time, middle.distance_m - half, middle.distance_m + half};
}

std::optional<WheelSample> to_sample(const sensor_msgs::JointState& message,
                                     const std::string& joint, double radius_m) {
  const auto found = std::find(message.name.begin(), message.name.end(), joint);
  const auto index = static_cast<std::size_t>(found - message.name.begin());
  if (index >= message.name.size() || index >= message.position.size()) return std::nullopt;
  return WheelSample{to_ns(message.header.stamp), message.position[index] * radius_m};
}

std::optional<WheelsSample> to_sample(const sensor_msgs::JointState& message,
                                      const std::vector<std::string>& left,
                                      const std::vector<std::string>& right, double radius_m) {
  WheelsSample sample{to_ns(message.header.stamp), 0.0, 0.0};
  const auto add = [&](const std::vector<std::string>& joints, double& side_m) {
    for (const std::string& joint : joints) {
      const auto wheel = to_sample(message, joint, radius_m);
      if (!wheel) return false;
      side_m += wheel->distance_m / static_cast<double>(joints.size());
    }
    return true;
  };
  if (!add(left, sample.left_m) || !add(right, sample.right_m)) return std::nullopt;
  return sample;
}

}  // namespace gprodom::ros1
