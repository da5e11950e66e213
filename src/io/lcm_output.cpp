// Encoding: estimates to LCM packets.
#include <algorithm>

#include "gprodom/lcm_io.h"
#include "io/lcm_time.h"
#include "lcmtypes/bot_core/pose_t.hpp"
#include "lcmtypes/gprodom/correction_t.hpp"
#include "lcmtypes/gprodom/displacement_t.hpp"
#include "lcmtypes/gprodom/odometry_t.hpp"
#include "lcmtypes/gprodom/sfm_t.hpp"
#include "lcmtypes/gprodom/status_t.hpp"

namespace gprodom {
namespace {

void copy(const Eigen::Vector3d& v, double (&array)[3]) {
  std::copy(v.data(), v.data() + 3, array);
}

void copy(const Eigen::Quaterniond& q, double (&wxyz)[4]) {
  wxyz[0] = q.w();
  wxyz[1] = q.x();
  wxyz[2] = q.y();
  wxyz[3] = q.z();
}

// Symmetric, so that row- and column-major are the same.
template <int N>
void copy(const Eigen::Matrix<double, N, N>& covariance, double (&array)[N * N]) {
  std::copy(covariance.data(), covariance.data() + N * N, array);
}

odometry_t to_message(const OdometryEstimate& estimate, const std::string& frame) {
  odometry_t m;
  m.utime = to_utime(estimate.time);
  m.frame = frame;
  copy(estimate.p_odom_body, m.position);
  copy(estimate.q_odom_body, m.orientation);
  copy(estimate.v_body, m.velocity);
  copy(estimate.omega_body, m.angular_velocity);
  copy(estimate.pose_covariance, m.pose_covariance);
  copy(estimate.velocity_covariance, m.velocity_covariance);
  copy(estimate.gyro_bias, m.gyro_bias);
  copy(estimate.accel_bias, m.accel_bias);
  m.wheel_scale = estimate.wheel_scale;
  m.wheel_scale_sigma = estimate.wheel_scale_sigma;
  m.distance = estimate.distance_m;
  m.flags = estimate.flags;
  return m;
}

// Viewers of this type expect the velocity in the frame of the pose and the turn rate in body. No
// acceleration is estimated, so it is left at zero.
bot_core::pose_t to_pose_message(const OdometryEstimate& estimate) {
  bot_core::pose_t m{};
  m.utime = to_utime(estimate.time);
  copy(estimate.p_odom_body, m.pos);
  copy(estimate.q_odom_body * estimate.v_body, m.vel);
  copy(estimate.q_odom_body, m.orientation);
  copy(estimate.omega_body, m.rotation_rate);
  return m;
}

displacement_t to_message(const Displacement& displacement) {
  displacement_t m;
  m.utime = to_utime(displacement.time);
  m.utime_from = to_utime(displacement.from);
  m.utime_to = to_utime(displacement.to);
  m.source = displacement.source;
  m.kind = static_cast<std::int8_t>(displacement.kind);
  m.valid = displacement.valid ? 1 : 0;
  m.distance = displacement.distance_m;
  m.sigma = displacement.sigma_m;
  m.lateral = displacement.lateral_m;
  m.lateral_sigma = displacement.lateral_sigma_m;
  m.mirrored = displacement.mirrored ? 1 : 0;
  m.scale = displacement.scale;
  m.score = displacement.score;
  return m;
}

correction_t to_message(const Correction& correction) {
  correction_t m;
  m.utime = to_utime(correction.time);
  copy(correction.p_map_odom, m.position);
  copy(correction.q_map_odom, m.orientation);
  m.revisits = correction.revisits;
  copy(correction.covariance, m.covariance);
  return m;
}

sfm_t to_message(const SubsurfaceFeatureMatrix& sfm) {
  sfm_t m;
  m.utime = to_utime(sfm.time);
  m.rows = static_cast<std::int32_t>(sfm.level.rows());
  m.columns = static_cast<std::int32_t>(sfm.level.cols());
  for (Eigen::Index row = 0; row < sfm.level.rows(); ++row) {
    const std::int8_t* level = sfm.level.row(row).data();
    m.level.emplace_back(level, level + sfm.level.cols());
  }
  m.column_spacing = sfm.column_spacing_s;
  return m;
}

status_t to_message(const Status& status) {
  status_t m;
  m.utime = to_utime(status.time);
  m.health = static_cast<std::int8_t>(status.health);
  m.reasons = status.reasons;
  m.num_reasons = static_cast<std::int32_t>(status.reasons.size());
  m.names = status.names;
  m.values = status.values;
  m.num_values = static_cast<std::int32_t>(status.values.size());
  return m;
}

template <class Message>
LcmMessage encode(const std::string& channel, const Message& message) {
  LcmMessage encoded;
  encoded.utime = message.utime;
  encoded.channel = channel;
  encoded.data.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(encoded.data.data(), 0, static_cast<int>(encoded.data.size()));
  return encoded;
}

}  // namespace

std::vector<LcmMessage> make_messages(const ChannelConfig& channels, const Outputs& outputs) {
  std::vector<LcmMessage> messages;
  const auto add = [&](const std::string& channel, const auto& items, const auto&... frame) {
    for (const auto& item : items) messages.push_back(encode(channel, to_message(item, frame...)));
  };
  add(channels.correction, outputs.corrections);
  add(channels.displacement, outputs.displacements);
  add(channels.sfm, outputs.sfm);
  add(channels.odometry, outputs.odometry, "odom");
  for (const auto& o : outputs.odometry_in_map) {
    messages.push_back(encode(channels.odometry_map, to_message(o, "map")));
    messages.push_back(encode(channels.pose, to_pose_message(o)));
  }
  add(channels.status, outputs.status);
  std::stable_sort(messages.begin(), messages.end(),
                   [](const LcmMessage& a, const LcmMessage& b) { return a.utime < b.utime; });
  return messages;
}

}  // namespace gprodom
