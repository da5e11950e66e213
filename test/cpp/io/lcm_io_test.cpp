#include "gprodom/lcm_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "io/encoded.h"
#include "lcmtypes/bot_core/pose_t.hpp"
#include "lcmtypes/gprodom/command_t.hpp"
#include "lcmtypes/gprodom/correction_t.hpp"
#include "lcmtypes/gprodom/displacement_t.hpp"
#include "lcmtypes/gprodom/gpr_trace_t.hpp"
#include "lcmtypes/gprodom/imu_t.hpp"
#include "lcmtypes/gprodom/odometry_t.hpp"
#include "lcmtypes/gprodom/position_fix_t.hpp"
#include "lcmtypes/gprodom/sfm_t.hpp"
#include "lcmtypes/gprodom/status_t.hpp"
#include "lcmtypes/gprodom/wheel_t.hpp"
#include "lcmtypes/gprodom/wheels_t.hpp"

namespace gprodom {
namespace {

const ChannelConfig kChannels;

Input decoded(const std::string& channel, const Bytes& bytes) {
  const auto input = decode_input(kChannels, channel, bytes.data(), bytes.size());
  EXPECT_TRUE(input.has_value());
  return input.value_or(Rejection{"", "nothing"});
}

// Why the packet was refused, or "accepted".
std::string refusal(const std::string& channel, const Bytes& bytes) {
  const Input input = decoded(channel, bytes);
  const auto* rejection = std::get_if<Rejection>(&input);
  if (!rejection) return "accepted";
  EXPECT_EQ(rejection->channel, channel);
  return rejection->reason;
}

imu_t imu_message() {
  imu_t m{};
  m.utime = 1700001000123456;
  for (int i = 0; i < 3; ++i) {
    m.linear_acceleration[i] = 0.5 + i;
    m.angular_velocity[i] = -0.25 * i;
  }
  return m;
}

gpr_trace_t trace_message(int samples) {
  gpr_trace_t m{};
  m.utime = 1700001000123456;
  m.seq = 77;
  m.antenna_id = 2;
  m.sample_interval = 2e-10;
  m.time_zero = 1e-9;
  m.volts_per_count = 1.5e-6;
  m.num_samples = samples;
  for (int i = 0; i < samples; ++i) m.samples.push_back((i % 2 ? -1 : 1) * 1000 * i);
  return m;
}

displacement_t displacement_message() {
  displacement_t m{};
  m.utime = 1700001000300000;
  m.utime_from = 1700001000100000;
  m.utime_to = 1700001000200000;
  m.source = "learned";
  m.kind = displacement_t::EXTERNAL;
  m.valid = 1;
  m.distance = -0.5;
  m.sigma = 0.05;
  m.lateral = 0.1;
  m.lateral_sigma = 0.2;
  m.mirrored = 1;
  m.scale = 1.25;
  m.score = 0.75;
  return m;
}

command_t command_message() {
  command_t m{};
  m.utime = 1700001000300000;
  m.name = "reset";
  m.argument = "";
  return m;
}

position_fix_t fix_message() {
  position_fix_t m{};
  m.utime = 1;
  m.frame = position_fix_t::GEODETIC;
  m.quality = position_fix_t::FIXED;
  m.antenna_id = 3;
  m.has_heading = 1;
  m.heading = 0.5;
  m.heading_sigma = 0.01;
  for (int i = 0; i < 3; ++i) m.position[i] = 10.0 + i;
  for (int i = 0; i < 9; ++i) m.covariance[i] = i;
  return m;
}

// Of every channel.
std::vector<std::pair<std::string, Bytes>> packets() {
  return {{"IMU", encoded(imu_message())},
          {"WHEEL", encoded(wheel_t{1, 2, 0.5})},
          {"WHEELS", encoded(wheels_t{1, 2, 3, 0.5})},
          {"GPR_TRACE", encoded(trace_message(20))},
          {"GPR_DISPLACEMENT_IN", encoded(displacement_message())},
          {"POSITION_FIX", encoded(fix_message())},
          {"COMMAND", encoded(command_message())}};
}

void put_int32(Bytes& bytes, std::size_t at, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(bits >> (24 - 8 * i));
}

TEST(LcmInput, DecodesImu) {
  const auto sample = std::get<ImuSample>(decoded("IMU", encoded(imu_message())));
  EXPECT_EQ(sample.time, 1700001000123456000);
  EXPECT_EQ(sample.acceleration, Eigen::Vector3d(0.5, 1.5, 2.5));
  EXPECT_EQ(sample.angular_velocity, Eigen::Vector3d(0, -0.25, -0.5));
}

TEST(LcmInput, DecodesWheelAsSignedDistance) {
  const auto sample = std::get<WheelSample>(decoded("WHEEL", encoded(wheel_t{1, -2000, 0.25})));
  EXPECT_EQ(sample.time, 1000);
  EXPECT_EQ(sample.distance_m, -500.0);
  EXPECT_EQ(sample.resolution_m, 0.25);
}

TEST(LcmInput, DecodesTwoWheelsAsSignedDistances) {
  const wheels_t m{1, -2000, 3000, 0.25};
  const auto input = std::get<WheelsSample>(decoded("WHEELS", encoded(m)));
  EXPECT_EQ(input.time, 1000);
  EXPECT_EQ(input.left_m, -500.0);
  EXPECT_EQ(input.right_m, 750.0);
  EXPECT_EQ(input.resolution_m, 0.25);
}

TEST(LcmInput, DecodesTrace) {
  const auto trace = std::get<GprTrace>(decoded("GPR_TRACE", encoded(trace_message(201))));
  EXPECT_EQ(trace.time, 1700001000123456000);
  EXPECT_EQ(trace.seq, 77);
  EXPECT_EQ(trace.antenna_id, 2);
  EXPECT_EQ(trace.sample_interval_s, 2e-10);
  EXPECT_EQ(trace.time_zero_s, 1e-9);
  EXPECT_EQ(trace.volts_per_count, 1.5e-6);
  ASSERT_EQ(trace.samples.size(), 201u);
  EXPECT_EQ(trace.samples[199], -199000.0f);
}

TEST(LcmInput, DecodesDisplacementAndCommand) {
  const auto d =
      std::get<Displacement>(decoded("GPR_DISPLACEMENT_IN", encoded(displacement_message())));
  EXPECT_EQ(d.time, 1700001000300000000);
  EXPECT_EQ(d.from, 1700001000100000000);
  EXPECT_EQ(d.to, 1700001000200000000);
  EXPECT_EQ(d.source, "learned");
  EXPECT_EQ(d.kind, DisplacementKind::kExternal);
  EXPECT_TRUE(d.valid && d.mirrored);
  EXPECT_EQ(d.distance_m, -0.5);
  EXPECT_EQ(d.sigma_m, 0.05);
  EXPECT_EQ(d.lateral_m, 0.1);
  EXPECT_EQ(d.lateral_sigma_m, 0.2);
  EXPECT_EQ(d.scale, 1.25);
  EXPECT_EQ(d.score, 0.75);

  EXPECT_EQ(std::get<Command>(decoded("COMMAND", encoded(command_message()))).name, "reset");
  EXPECT_FALSE(decode_input(kChannels, "TOTAL_STATION", nullptr, 0).has_value());
}

TEST(LcmInput, DecodesPositionFix) {
  const auto fix = std::get<PositionFix>(decoded("POSITION_FIX", encoded(fix_message())));
  EXPECT_EQ(fix.time, 1000);
  EXPECT_EQ(fix.frame, FixFrame::kGeodetic);
  EXPECT_EQ(fix.position, Eigen::Vector3d(10, 11, 12));
  EXPECT_EQ(fix.covariance(0, 1), 1.0);  // row-major
  EXPECT_EQ(fix.quality, FixQuality::kFixed);
  EXPECT_EQ(fix.antenna_id, 3);
  EXPECT_TRUE(fix.has_heading);
  EXPECT_EQ(fix.heading, 0.5);
  EXPECT_EQ(fix.heading_sigma, 0.01);
}

TEST(LcmInput, RefusesPositionFixOfUnknownFrameOrQuality) {
  position_fix_t m = fix_message();
  m.frame = 2;
  EXPECT_NE(refusal("POSITION_FIX", encoded(m)).find("frame"), std::string::npos);
  m = fix_message();
  m.quality = 5;
  EXPECT_NE(refusal("POSITION_FIX", encoded(m)).find("quality"), std::string::npos);
}

TEST(LcmInput, NanIsPassedOnToTheEstimator) {
  imu_t m = imu_message();
  m.angular_velocity[1] = std::nan("");
  EXPECT_TRUE(std::isnan(std::get<ImuSample>(decoded("IMU", encoded(m))).angular_velocity.y()));
}

TEST(LcmInput, RefusesHostileCounts) {
  const Bytes good = encoded(trace_message(10));
  const std::size_t count_at = good.size() - 10 * 4 - 4;
  for (const std::int32_t count : {-1, std::numeric_limits<std::int32_t>::min(), 11, 65536, 1 << 30,
                                   std::numeric_limits<std::int32_t>::max()}) {
    Bytes bytes = good;
    put_int32(bytes, count_at, count);
    EXPECT_NE(refusal("GPR_TRACE", bytes), "accepted") << count;
  }
  Bytes fewer = good;
  put_int32(fewer, count_at, 9);
  EXPECT_EQ(refusal("GPR_TRACE", fewer), "message has bytes left over");
  EXPECT_EQ(refusal("GPR_TRACE", good), "accepted");
}

TEST(LcmInput, RefusesHostileStrings) {
  const Bytes good = encoded(displacement_message());
  const std::size_t length_at = 8 + 3 * 8;
  for (const std::int32_t length :
       {-1, 0, 1, 7, 9, 4096, 4097, 1 << 30, std::numeric_limits<std::int32_t>::max(),
        std::numeric_limits<std::int32_t>::min()}) {
    Bytes bytes = good;
    put_int32(bytes, length_at, length);
    EXPECT_NE(refusal("GPR_DISPLACEMENT_IN", bytes), "accepted") << length;
  }
  Bytes unterminated = good;
  unterminated[length_at + 4 + 7] = 'x';
  EXPECT_NE(refusal("GPR_DISPLACEMENT_IN", unterminated), "accepted");
  displacement_t kind = displacement_message();
  kind.kind = 4;
  EXPECT_NE(refusal("GPR_DISPLACEMENT_IN", encoded(kind)).find("unknown kind"), std::string::npos);
}

TEST(LcmInput, RefusesTimesThatDoNotFit) {
  imu_t m = imu_message();
  for (const std::int64_t utime : {std::int64_t{-1}, std::numeric_limits<std::int64_t>::max(),
                                   std::numeric_limits<std::int64_t>::min()}) {
    m.utime = utime;
    EXPECT_NE(refusal("IMU", encoded(m)).find("out of range"), std::string::npos) << utime;
  }
  displacement_t d = displacement_message();
  d.utime_from = std::numeric_limits<std::int64_t>::max();
  EXPECT_NE(refusal("GPR_DISPLACEMENT_IN", encoded(d)), "accepted");
}

TEST(LcmInput, RefusesEveryTruncationAndOtherTypes) {
  for (const auto& [channel, packet] : packets()) {
    ASSERT_EQ(refusal(channel, packet), "accepted");
    for (std::size_t size = 0; size < packet.size(); ++size) {
      // A copy of exactly this size, so that a sanitizer sees a read behind it.
      EXPECT_NE(refusal(channel, Bytes(packet.begin(), packet.begin() + size)), "accepted")
          << channel << " " << size;
    }
    for (const auto& [other, unused] : packets()) {
      if (other != channel) {
        EXPECT_NE(refusal(other, packet).find("another message type"), std::string::npos);
      }
    }
  }
}

// Packets whose bytes are overwritten at random, most of them near the front where counts and
// lengths stand. Whatever is accepted must be the size of its packet.
TEST(LcmInput, SurvivesRandomBytes) {
  std::mt19937 random(20240611);
  const auto all = packets();
  int accepted = 0;
  constexpr int kRounds = 100000;
  for (int round = 0; round < kRounds; ++round) {
    const auto& [channel, good] = all[random() % all.size()];
    Bytes bytes = good;
    if (random() % 4 == 0) bytes.resize(random() % (good.size() + 16));
    for (unsigned n = random() % 6; n > 0 && bytes.size() > 8; --n) {
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::uint8_t>(random());
    }
    const auto input = decode_input(kChannels, channel, bytes.data(), bytes.size());
    ASSERT_TRUE(input.has_value());
    if (const auto* trace = std::get_if<GprTrace>(&*input)) {
      ASSERT_EQ(trace->samples.size(), (bytes.size() - 56) / 4);
    }
    accepted += !std::holds_alternative<Rejection>(*input);
  }
  EXPECT_GT(accepted, kRounds / 10);  // the test reaches behind the checks
  EXPECT_LT(accepted, kRounds * 9 / 10);
}

template <class Message>
Message find(const std::vector<LcmMessage>& messages, const std::string& channel) {
  Message message{};
  for (const auto& m : messages) {
    if (m.channel != channel) continue;
    EXPECT_EQ(message.decode(m.data.data(), 0, static_cast<int>(m.data.size())),
              static_cast<int>(m.data.size()));
    EXPECT_EQ(m.utime, message.utime);
    return message;
  }
  ADD_FAILURE() << "no message on " << channel;
  return message;
}

TEST(LcmOutput, MessagesHoldTheOutputs) {
  Outputs outputs;
  OdometryEstimate odometry;
  odometry.time = 5'000'001'999;
  odometry.p_odom_body = {1, 2, 3};
  odometry.q_odom_body = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  odometry.v_body = {0.5, 0, 0};
  odometry.omega_body = {0, 0, 0.25};
  odometry.pose_covariance(0, 5) = odometry.pose_covariance(5, 0) = 0.125;
  odometry.velocity_covariance(1, 2) = odometry.velocity_covariance(2, 1) = 0.5;
  odometry.gyro_bias = {0.1, 0.2, 0.3};
  odometry.accel_bias = {0.4, 0.5, 0.6};
  odometry.wheel_scale = 1.02;
  odometry.wheel_scale_sigma = 0.01;
  odometry.distance_m = 12.5;
  odometry.flags = kStanding | kNoRadar;
  outputs.odometry = {odometry};
  OdometryEstimate in_map = odometry;
  in_map.p_odom_body = {10, 20, 30};
  Correction correction;
  correction.time = 4'000'000'000;
  correction.p_map_odom = {7, 8, 9};
  correction.revisits = 3;
  outputs.corrections = {correction};
  Status status;
  status.time = 4'500'000'000;
  status.health = HealthLevel::kDegraded;
  status.reasons = {"no radar"};
  status.names = {"a", "b"};
  status.values = {1, 2};
  outputs.status = {status};
  SubsurfaceFeatureMatrix sfm;
  sfm.time = 4'600'000'000;
  sfm.level.resize(2, 3);
  sfm.level << 1, 2, 3, 4, 5, 10;
  sfm.column_spacing_s = 0.05;
  outputs.sfm = {sfm};
  outputs.displacements = {
      std::get<Displacement>(decoded("GPR_DISPLACEMENT_IN", encoded(displacement_message())))};
  outputs.odometry_in_map = {in_map};
  const auto messages = make_messages(kChannels, outputs);
  ASSERT_EQ(messages.size(), 7u);
  for (std::size_t i = 1; i < messages.size(); ++i) {
    EXPECT_LE(messages[i - 1].utime, messages[i].utime);
  }

  const auto o = find<odometry_t>(messages, "ODOMETRY");
  EXPECT_EQ(o.utime, 5'000'001);
  EXPECT_EQ(o.frame, "odom");
  EXPECT_EQ(o.position[1], 2);
  EXPECT_NEAR(o.orientation[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(o.orientation[3], std::sqrt(0.5), 1e-15);
  EXPECT_EQ(o.velocity[0], 0.5);
  EXPECT_EQ(o.angular_velocity[2], 0.25);
  EXPECT_EQ(o.pose_covariance[5], 0.125);
  EXPECT_EQ(o.pose_covariance[30], 0.125);
  EXPECT_EQ(o.velocity_covariance[5], 0.5);
  EXPECT_EQ(o.gyro_bias[2], 0.3);
  EXPECT_EQ(o.accel_bias[0], 0.4);
  EXPECT_EQ(o.wheel_scale, 1.02);
  EXPECT_EQ(o.wheel_scale_sigma, 0.01);
  EXPECT_EQ(o.distance, 12.5);
  EXPECT_EQ(o.flags, odometry_t::STANDING | odometry_t::NO_RADAR);

  const auto m = find<odometry_t>(messages, "ODOMETRY_MAP");
  EXPECT_EQ(m.frame, "map");
  EXPECT_EQ(m.position[2], 30);
  const auto pose = find<bot_core::pose_t>(messages, "POSE");
  EXPECT_EQ(pose.pos[0], 10);
  EXPECT_NEAR(pose.vel[1], 0.5, 1e-15);  // faces y: body x is map y
  EXPECT_EQ(pose.rotation_rate[2], 0.25);

  const auto c = find<correction_t>(messages, "CORRECTION");
  EXPECT_EQ(c.position[2], 9);
  EXPECT_EQ(c.orientation[0], 1);
  EXPECT_EQ(c.revisits, 3);
  const auto s = find<status_t>(messages, "STATUS");
  EXPECT_EQ(s.health, status_t::DEGRADED);
  EXPECT_EQ(s.reasons, status.reasons);
  EXPECT_EQ(s.names, status.names);
  EXPECT_EQ(s.values, status.values);
  const auto f = find<sfm_t>(messages, "SFM");
  EXPECT_EQ(f.rows, 2);
  EXPECT_EQ(f.columns, 3);
  EXPECT_EQ(f.level[1], (std::vector<std::int8_t>{4, 5, 10}));
  EXPECT_EQ(f.column_spacing, 0.05);

  // Out and in again is the same displacement.
  EXPECT_EQ(encoded(find<displacement_t>(messages, "GPR_DISPLACEMENT")),
            encoded(displacement_message()));
}

}  // namespace
}  // namespace gprodom
