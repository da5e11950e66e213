#include <cmath>

#include "apps/replay.h"
#include "base/text.h"

namespace gprodom {
namespace {

std::string json(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (code < 0x20) {
      quoted += formatted("\\u%04x", code);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string json(double number) {
  return std::isfinite(number) ? formatted("%.9g", number) : "null";
}

std::string json(long number) { return std::to_string(number); }

std::string json(const std::vector<std::string>& texts) {
  std::string list;
  for (const auto& text : texts) list += (list.empty() ? "" : ", ") + json(text);
  return "[" + list + "]";
}

std::string json(const FixAntenna& antenna) {
  const Eigen::Vector3d& p = antenna.place;
  return "{\"place\": [" + json(p.x()) + ", " + json(p.y()) + ", " + json(p.z()) +
         "], \"delay\": " + json(antenna.delay) + "}";
}

template <class Value>
std::string json(const std::map<std::string, Value>& values) {
  std::string object;
  for (const auto& [name, value] : values) {
    object += (object.empty() ? "" : ", ") + json(name) + ": " + json(value);
  }
  return "{" + object + "}";
}

std::string json(const WorkTime& time) {
  const double mean = time.jobs > 0 ? time.total_s / static_cast<double>(time.jobs) : 0.0;
  return "{\"jobs\": " + std::to_string(time.jobs) + ", \"mean_ms\": " + json(1e3 * mean) +
         ", \"longest_ms\": " + json(1e3 * time.longest_s) + "}";
}

}  // namespace

std::string to_json(const ReplayStats& stats) {
  std::map<std::string, double> values;
  const Status& status = stats.last_status;
  for (std::size_t i = 0; i < status.names.size() && i < status.values.size(); ++i) {
    values[status.names[i]] = status.values[i];
  }
  std::map<std::string, FixAntenna> antennas;
  for (const auto& [id, antenna] : stats.antennas) antennas[std::to_string(id)] = antenna;
  const double ratio = stats.wall_seconds > 0 ? stats.log_seconds / stats.wall_seconds : 0.0;
  return "{\n  \"read\": " + json(stats.read) + ",\n  \"published\": " + json(stats.published) +
         ",\n  \"unused\": " + json(stats.unused) + ",\n  \"refused\": " + json(stats.refused) +
         ",\n  \"poses\": " + json(stats.poses) + ",\n  \"damage\": " + json(stats.damage) +
         ",\n  \"warnings\": " + json(stats.warnings) +
         ",\n  \"log_seconds\": " + json(stats.log_seconds) +
         ",\n  \"wall_seconds\": " + json(stats.wall_seconds) +
         ",\n  \"times_real_time\": " + json(ratio) +
         ",\n  \"solver\": " + json(stats.timing.solver) +
         ",\n  \"radar\": " + json(stats.timing.radar) + ",\n  \"antennas\": " + json(antennas) +
         ",\n  \"health\": " + json(name_of(status.health)) +
         ",\n  \"reasons\": " + json(status.reasons) + ",\n  \"values\": " + json(values) + "\n}\n";
}

}  // namespace gprodom
