#include "settings.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <sstream>
#include <type_traits>
#include <variant>

#include "gprodom/error.h"
#include "wheels.h"

namespace gprodom::ros2 {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();

struct Setting {
  const char* name;
  std::variant<bool*, int*, double*, std::string*, WheelMessage*> field;
  const char* meaning;
  double minimum = -kAny, maximum = kAny;  // of numbers
};

// clang-format off
std::vector<Setting> table(Settings& s) {
  return {
    {"domain", &s.domain, "the DDS domain, ROS_DOMAIN_ID of the other nodes", 0, 232},
    {"interface", &s.interface, "network interface, by name or address; lo: nothing leaves the machine; empty: what CYCLONEDDS_URI says"},
    {"namespace", &s.name_space, "put before names of topics that do not begin with /"},
    {"imu", &s.imu, "in: sensor_msgs/Imu"},
    {"gpr", &s.gpr, "in: gprodom_msgs/GprTrace, of all antennas, told apart by antenna_id"},
    {"wheel", &s.wheel, "in: what wheel_message says"},
    {"fix", &s.fix, "in: sensor_msgs/NavSatFix, a position of the antenna 0 of anchor.antennas"},
    {"site_pose", &s.site_pose, "in: geometry_msgs/PoseWithCovarianceStamped, a pose of the robot in site, of a total station or another estimator; antenna 0 likewise"},
    {"initialpose", &s.initialpose, "in: geometry_msgs/PoseWithCovarianceStamped in the map frame, the command locate_at"},
    {"command", &s.command, "in: gprodom_msgs/Command: reset, save_map, load_map or locate_at"},
    {"odometry", &s.odometry, "out: nav_msgs/Odometry in odom, continuous"},
    {"odometry_map", &s.odometry_map, "out: nav_msgs/Odometry in map, may jump"},
    {"revisits", &s.revisits, "out: gprodom_msgs/Revisit, ground that was recognised"},
    {"tf", &s.tf, "out: tf2_msgs/TFMessage, map to odom to base_link"},
    {"tf_static", &s.tf_static, "out: tf2_msgs/TFMessage, base_link to the antennas; for late subscribers, too"},
    {"diagnostics", &s.diagnostics, "out: diagnostic_msgs/DiagnosticArray, once a second"},
    {"wheel_message", &s.wheel_message, "odometry: nav_msgs/Odometry; twist: geometry_msgs/TwistStamped; joint, joints: sensor_msgs/JointState; ticks: std_msgs/Int64; none"},
    {"wheel_joint", &s.wheel_joint, "joint: its name"},
    {"left_joints", &s.left_joints, "joints: names of the left side, by commas"},
    {"right_joints", &s.right_joints, "joints: names of the right side, by commas"},
    {"wheel_radius", &s.wheel_radius, "m; joint, joints: angle times radius is distance", 0, 10},
    {"track", &s.track, "m; odometry, twist: between left and right wheels in the driver that sends them, whose yaw rate is used; 0: it is not", 0, 10},
    {"metres_per_tick", &s.metres_per_tick, "m; ticks", 0, 10},
    {"map_frame", &s.frames.map, "frame that revisits correct"},
    {"odom_frame", &s.frames.odom, "continuous frame"},
    {"base_frame", &s.frames.body, "frame of the robot"},
    {"gpr_frame", &s.gpr_frame, "frame of the antenna in tf_static, at gpr.lever_arm, of the first in gpr.antennas; with _ID that of a further one; empty: none, where a robot description has them"},
    {"publish_tf", &s.publish_tf, "false where another node publishes odom to base_link"},
    {"sensors_reliable", &s.sensors_reliable, "false: best effort, which takes what any publisher sends; true: only from publishers that are reliable"},
    {"sensor_depth", &s.sensor_depth, "messages kept of each sensor until they are taken", 1, 1000000},
    {"depth", &s.depth, "messages kept of each topic for subscribers that are slow", 1, 1000000},
    {"use_sim_time", &s.use_sim_time, "ticks, which have no stamp: true: they are of the time on /clock; false: of the time when they came"},
  };
}
// clang-format on

// Puts a node's value into the field of a setting. Returns what was expected where it does not fit;
// the field is then as it was.
struct Assign {
  const Setting& setting;
  const YAML::Node& node;
  std::string operator()(bool* field) const {
    return YAML::convert<bool>::decode(node, *field) ? "" : "true or false";
  }
  std::string operator()(std::string* field) const {
    if (!node.IsScalar()) return "text";
    *field = node.Scalar();
    return "";
  }
  std::string operator()(WheelMessage* field) const {
    const auto choice = node.IsScalar() ? find_choice<WheelMessage>(node.Scalar()) : std::nullopt;
    if (!choice) return "one of " + all_names<WheelMessage>(", ", " or ");
    *field = *choice;
    return "";
  }
  template <class Number>
  std::string operator()(Number* field) const {
    Number value{};
    if (YAML::convert<Number>::decode(node, value) && value >= setting.minimum &&
        value <= setting.maximum) {
      *field = value;
      return "";
    }
    std::ostringstream text;
    text << (std::is_same_v<Number, int> ? "an integer, " : "a number, ") << setting.minimum
         << " to " << setting.maximum;
    return text.str();
  }
};

void set(std::vector<Setting>& settings, const std::string& name, const YAML::Node& node,
         const std::string& place) {
  const auto found = std::find_if(settings.begin(), settings.end(),
                                  [&](const Setting& s) { return name == s.name; });
  if (found == settings.end())
    throw ConfigError(place + name + ": there is no such setting; --print-settings shows them all");
  const std::string expected = std::visit(Assign{*found, node}, found->field);
  if (!expected.empty()) throw ConfigError(place + name + ": expected " + expected);
}

void read(std::vector<Setting>& settings, const std::string& path) {
  try {
    const YAML::Node file = YAML::LoadFile(path);
    if (file.IsNull()) return;
    if (!file.IsMap()) throw ConfigError(path + ": expected lines of name: value");
    for (const auto& entry : file) {
      const int line = entry.first.Mark().line + 1;
      set(settings, entry.first.Scalar(), entry.second, path + ":" + std::to_string(line) + ": ");
    }
  } catch (const YAML::BadFile&) {
    throw ConfigError(path + ": cannot be read");
  } catch (const YAML::Exception& error) {
    throw ConfigError(path + ": " + error.what());
  }
}

// What one setting asks of another.
void check(const Settings& s) {
  const auto need = [&](bool there, const std::string& what) {
    if (!there) throw ConfigError("wheel_message: " + name_of(s.wheel_message) + ": " + what);
  };
  const WheelMessage wheel = s.wheel_message;
  const bool joints = wheel == WheelMessage::kJoints;
  need(wheel != WheelMessage::kJoint || !s.wheel_joint.empty(), "set wheel_joint, a joint's name");
  need(!joints || !ros_shared::names_by_commas(s.left_joints).empty(), "set left_joints");
  need(!joints || !ros_shared::names_by_commas(s.right_joints).empty(), "set right_joints");
  need((!joints && wheel != WheelMessage::kJoint) || s.wheel_radius > 0, "set wheel_radius (m)");
  need(wheel != WheelMessage::kTicks || s.metres_per_tick > 0, "set metres_per_tick (m)");
  if (s.name_space.empty() || s.name_space.front() != '/')
    throw ConfigError("namespace: expected a name that begins with /");
  const auto words = {s.imu,         s.gpr,       s.wheel,       s.fix,          s.site_pose,
                      s.initialpose, s.command,   s.odometry,    s.odometry_map, s.revisits,
                      s.tf,          s.tf_static, s.diagnostics, s.name_space};
  for (const std::string& word : words) {
    const bool fits = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
      return std::isalnum(c) || c == '_' || c == '/';
    });
    if (!fits) throw ConfigError("'" + word + "': not a name of ROS 2: letters, digits, _ and /");
  }
}

}  // namespace

Settings load_settings(const std::vector<std::string>& paths,
                       const std::vector<std::string>& values) {
  Settings settings;
  auto all = table(settings);
  for (const std::string& path : paths) read(all, path);
  for (const std::string& value : values) {
    const auto split = value.find(":=");
    if (split == std::string::npos) throw ConfigError(value + ": expected NAME:=VALUE");
    YAML::Node node(value.substr(split + 2));
    set(all, value.substr(0, split), node, "");
  }
  check(settings);
  return settings;
}

std::string describe(Settings settings) {
  YAML::Emitter out;
  out << YAML::Comment(
             "Every setting of gprodom_ros2 beside the estimator's own (gprodom.yaml); written by\n"
             "gprodom_ros2 --print-settings. A file needs only those that differ.")
      << YAML::BeginMap;
  for (const Setting& s : table(settings)) {
    out << YAML::Newline << YAML::Comment(s.meaning) << YAML::Key << s.name << YAML::Value;
    std::visit(
        [&](auto* field) {
          if constexpr (std::is_same_v<decltype(field), WheelMessage*>)
            out << name_of(*field);
          else
            out << *field;
        },
        s.field);
  }
  out << YAML::EndMap << YAML::Newline;
  return out.c_str();
}

std::string on_the_wire(const Settings& settings, const std::string& topic) {
  if (topic.front() == '/') return "rt" + topic;
  const std::string& space = settings.name_space;
  return "rt" + space + (space.back() == '/' ? "" : "/") + topic;
}

}  // namespace gprodom::ros2
