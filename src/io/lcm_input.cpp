// Decoding: LCM packets to inputs.
#include <cmath>

#include "gprodom/lcm_io.h"
#include "io/lcm_time.h"
#include "io/packet_layout.h"
#include "lcmtypes/gprodom/command_t.hpp"
#include "lcmtypes/gprodom/displacement_t.hpp"
#include "lcmtypes/gprodom/gpr_trace_t.hpp"
#include "lcmtypes/gprodom/imu_t.hpp"
#include "lcmtypes/gprodom/position_fix_t.hpp"
#include "lcmtypes/gprodom/wheel_t.hpp"
#include "lcmtypes/gprodom/wheels_t.hpp"

namespace gprodom {
namespace {

constexpr std::size_t kMaxSamples = 65536;  // of a trace; radars have some hundreds to thousands

struct Packet {
  const std::string& channel;
  const void* data;
  std::size_t size;

  PacketLayout layout(std::int64_t fingerprint) const { return {data, size, fingerprint}; }
};

Rejection rejection(const Packet& packet, const std::string& fault) {
  return {packet.channel, "message " + fault};
}

// Decodes the packet as Message once `fault`, of its layout, is empty, and converts it.
template <class Message, class Convert>
Input decode(const Packet& packet, const std::string& fault, Convert convert) {
  if (!fault.empty()) return rejection(packet, fault);
  Message message{};
  if (message.decode(packet.data, 0, static_cast<int>(packet.size)) < 0) {
    return rejection(packet, "cannot be decoded");
  }
  if (!utime_fits(message.utime)) {
    return rejection(packet, "has a utime out of range");
  }
  return convert(message);
}

Input decode_imu(const Packet& packet) {
  const std::string fault = packet.layout(imu_t::getHash())
                                .fixed(8 + 3 * 8 + 3 * 8)  // utime … angular_velocity
                                .fixed(1 + 4 * 8)          // orientation
                                .end();
  return decode<imu_t>(packet, fault, [](const imu_t& m) -> Input {
    return ImuSample{from_utime(m.utime), Eigen::Map<const Eigen::Vector3d>(m.linear_acceleration),
                     Eigen::Map<const Eigen::Vector3d>(m.angular_velocity)};
  });
}

Input decode_wheel(const Packet& packet) {
  const std::string fault = packet.layout(wheel_t::getHash()).fixed(8 + 8 + 8).end();
  return decode<wheel_t>(packet, fault, [](const wheel_t& m) -> Input {
    return WheelSample{from_utime(m.utime), static_cast<double>(m.ticks) * m.metres_per_tick,
                       std::abs(m.metres_per_tick)};
  });
}

Input decode_wheels(const Packet& packet) {
  const std::string fault = packet.layout(wheels_t::getHash()).fixed(8 + 2 * 8 + 8).end();
  return decode<wheels_t>(packet, fault, [](const wheels_t& m) -> Input {
    return WheelsSample{from_utime(m.utime), static_cast<double>(m.left_ticks) * m.metres_per_tick,
                        static_cast<double>(m.right_ticks) * m.metres_per_tick,
                        std::abs(m.metres_per_tick)};
  });
}

Input decode_trace(const Packet& packet) {
  const std::string fault = packet.layout(gpr_trace_t::getHash())
                                .fixed(8 + 8 + 4 + 3 * 8)  // utime … volts_per_count
                                .counted_array("samples", 4, kMaxSamples)
                                .end();
  return decode<gpr_trace_t>(packet, fault, [](const gpr_trace_t& m) -> Input {
    GprTrace trace;
    trace.time = from_utime(m.utime);
    trace.seq = m.seq;
    trace.antenna_id = m.antenna_id;
    trace.sample_interval_s = m.sample_interval;
    trace.time_zero_s = m.time_zero;
    trace.volts_per_count = m.volts_per_count;
    trace.samples.assign(m.samples.begin(), m.samples.end());
    return trace;
  });
}

Input decode_displacement(const Packet& packet) {
  const std::string fault = packet.layout(displacement_t::getHash())
                                .fixed(3 * 8)  // utime, utime_from, utime_to
                                .string("source")
                                .fixed(1 + 1 + 4 * 8 + 1 + 2 * 8)  // kind … score
                                .end();
  return decode<displacement_t>(packet, fault, [&](const displacement_t& m) -> Input {
    if (m.kind < displacement_t::SEQUENTIAL || m.kind > displacement_t::EXTERNAL) {
      return rejection(packet, "has an unknown kind");
    }
    if (!utime_fits(m.utime_from) || !utime_fits(m.utime_to)) {
      return rejection(packet, "has a utime_from or utime_to out of range");
    }
    Displacement d;
    d.time = from_utime(m.utime);
    d.from = from_utime(m.utime_from);
    d.to = from_utime(m.utime_to);
    d.source = m.source;
    d.kind = static_cast<DisplacementKind>(m.kind);
    d.valid = m.valid != 0;
    d.distance_m = m.distance;
    d.sigma_m = m.sigma;
    d.lateral_m = m.lateral;
    d.lateral_sigma_m = m.lateral_sigma;
    d.mirrored = m.mirrored != 0;
    d.scale = m.scale;
    d.score = m.score;
    return d;
  });
}

Input decode_fix(const Packet& packet) {
  const std::string fault = packet.layout(position_fix_t::getHash())
                                .fixed(8 + 1 + 3 * 8 + 9 * 8)  // utime … covariance
                                .fixed(1 + 4 + 1 + 2 * 8)      // quality … heading_sigma
                                .end();
  return decode<position_fix_t>(packet, fault, [&](const position_fix_t& m) -> Input {
    if (m.frame < position_fix_t::SITE || m.frame > position_fix_t::GEODETIC)
      return rejection(packet, "has an unknown frame");
    if (m.quality < position_fix_t::NONE || m.quality > position_fix_t::SURVEYED)
      return rejection(packet, "has an unknown quality");
    PositionFix fix;
    fix.time = from_utime(m.utime);
    fix.frame = static_cast<FixFrame>(m.frame);
    fix.position = Eigen::Map<const Eigen::Vector3d>(m.position);
    fix.covariance = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.covariance);
    fix.quality = static_cast<FixQuality>(m.quality);
    fix.antenna_id = m.antenna_id;
    fix.has_heading = m.has_heading != 0;
    fix.heading = m.heading;
    fix.heading_sigma = m.heading_sigma;
    return fix;
  });
}

Input decode_command(const Packet& packet) {
  const std::string fault =
      packet.layout(command_t::getHash()).fixed(8).string("name").string("argument").end();
  return decode<command_t>(packet, fault, [](const command_t& m) -> Input {
    return Command{from_utime(m.utime), m.name, m.argument};
  });
}

}  // namespace

std::vector<std::string> input_channels(const ChannelConfig& channels) {
  return {channels.gpr_trace,       channels.imu,          channels.wheel,  channels.wheels,
          channels.displacement_in, channels.position_fix, channels.command};
}

std::optional<Input> decode_input(const ChannelConfig& channels, const std::string& channel,
                                  const void* data, std::size_t size) {
  const Packet packet{channel, data, size};
  if (channel == channels.imu) return decode_imu(packet);
  if (channel == channels.wheel) return decode_wheel(packet);
  if (channel == channels.wheels) return decode_wheels(packet);
  if (channel == channels.gpr_trace) return decode_trace(packet);
  if (channel == channels.displacement_in) return decode_displacement(packet);
  if (channel == channels.position_fix) return decode_fix(packet);
  if (channel == channels.command) return decode_command(packet);
  return std::nullopt;
}

}  // namespace gprodom
