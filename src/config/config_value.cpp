#include "config/config_value.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <type_traits>

namespace gprodom {
namespace {

std::string to_text(double value) {
  std::array<char, 32> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string to_text(const Eigen::Vector3d& v) {
  return "[" + to_text(v.x()) + ", " + to_text(v.y()) + ", " + to_text(v.z()) + "]";
}

std::string to_text(const std::optional<Eigen::Vector3d>& v) { return v ? to_text(*v) : "[]"; }

std::string to_text(const MountingAngles& angles) {
  return angles.rpy ? to_text(*angles.rpy) : "auto";
}

template <class Value>
std::string to_text(const std::map<int, Value>& by_antenna) {
  std::string text;
  for (const auto& [id, value] : by_antenna)
    text += (text.empty() ? "" : ", ") + std::to_string(id) + ": " + to_text(value);
  return "{" + text + "}";
}

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << text;  // with quotes if YAML needs them
  return emitter.c_str();
}

// The whole text must be one number; not "1.0abc", not "nan". Independent of the process's locale.
template <class Number>
std::optional<Number> parse_number(std::string text) {
  if (!text.empty() && text.front() == '+') text.erase(0, 1);
  Number number{};
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  if (result.ec != std::errc() || result.ptr != end || !std::isfinite(double(number))) {
    return std::nullopt;
  }
  return number;
}

bool within(const Range& range, double value) {
  return (range.above_minimum ? value > range.minimum : value >= range.minimum) &&
         value <= range.maximum;
}

template <class Number>
std::optional<Number> number_within(const ConfigKey& key, const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  const auto number = parse_number<Number>(node.Scalar());
  if (!number || !within(std::get<Range>(key.allowed), double(*number))) return std::nullopt;
  return number;
}

// One overload for each type of field. Returns the value, or nothing if the node does not fit.
std::optional<bool> parse(const ConfigKey&, const YAML::Node& node, const bool*) {
  bool value = false;
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) return std::nullopt;
  return value;
}

std::optional<int> parse(const ConfigKey& key, const YAML::Node& node, const int*) {
  return number_within<int>(key, node);
}

std::optional<double> parse(const ConfigKey& key, const YAML::Node& node, const double*) {
  return number_within<double>(key, node);
}

std::optional<Eigen::Vector3d> vector_within(const ConfigKey& key, const YAML::Node& node) {
  if (!node.IsSequence() || node.size() != 3) return std::nullopt;
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) {
    const auto component = number_within<double>(key, node[i]);
    if (!component) return std::nullopt;
    vector[i] = *component;
  }
  return vector;
}

std::optional<Eigen::Vector3d> parse(const ConfigKey& key, const YAML::Node& node,
                                     const Eigen::Vector3d*) {
  return vector_within(key, node);
}

// An empty list: not given.
std::optional<std::optional<Eigen::Vector3d>> parse(const ConfigKey& key, const YAML::Node& node,
                                                    const std::optional<Eigen::Vector3d>*) {
  if (node.IsSequence() && node.size() == 0) return std::optional<Eigen::Vector3d>();
  const auto vector = vector_within(key, node);
  if (!vector) return std::nullopt;
  return vector;
}

std::optional<MountingAngles> parse(const ConfigKey& key, const YAML::Node& node,
                                    const MountingAngles*) {
  if (node.IsScalar() && node.Scalar() == "auto") return MountingAngles{std::nullopt};
  const auto angles = vector_within(key, node);
  if (!angles) return std::nullopt;
  return MountingAngles{angles};
}

template <class Value>
std::optional<std::map<int, Value>> parse(const ConfigKey& key, const YAML::Node& node,
                                          const std::map<int, Value>*) {
  if (!node.IsMap()) return std::nullopt;
  std::map<int, Value> by_antenna;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) return std::nullopt;
    const auto id = parse_number<int>(entry.first.Scalar());
    const auto value = parse(key, entry.second, static_cast<const Value*>(nullptr));
    if (!id || !value || !by_antenna.emplace(*id, *value).second) return std::nullopt;
  }
  return by_antenna;
}

std::optional<std::string> parse(const ConfigKey& key, const YAML::Node& node, const std::string*) {
  const auto& limit = std::get<Text>(key.allowed);
  if (!node.IsScalar() || (node.Scalar().empty() && !limit.may_be_empty)) return std::nullopt;
  if (node.Scalar().size() > limit.max_length) return std::nullopt;
  return node.Scalar();
}

template <class Choice>
std::optional<Choice> parse(const ConfigKey&, const YAML::Node& node, const Choice*) {
  if (!node.IsScalar()) return std::nullopt;
  return find_choice<Choice>(node.Scalar());
}

// The names of an enum's values; empty for any other type of field.
template <class Field>
std::string choices_of(const Field*) {
  if constexpr (std::is_enum_v<Field>) return all_names<Field>();
  return {};
}

struct KindName {
  std::string operator()(const bool*) const { return "true or false"; }
  std::string operator()(const int*) const { return "an integer"; }
  std::string operator()(const double*) const { return "a number"; }
  std::string operator()(const std::string*) const { return "text"; }
  std::string operator()(const Eigen::Vector3d*) const { return "[x, y, z], three numbers"; }
  std::string operator()(const std::optional<Eigen::Vector3d>*) const {
    return "[a, b, c], three numbers, or []";
  }
  std::string operator()(const MountingAngles*) const {
    return "auto, or [roll, pitch, yaw], three numbers";
  }
  std::string operator()(const Antennas*) const {
    return "a map of antenna_id to [x, y, z], each id once";
  }
  std::string operator()(const AntennaOffsets*) const {
    return "a map of antenna_id to a number, each id once,";
  }
  template <class Choice>
  std::string operator()(const Choice*) const {
    return "one of";
  }
};

struct ValueText {
  std::string operator()(const bool* field) const { return *field ? "true" : "false"; }
  std::string operator()(const int* field) const { return std::to_string(*field); }
  std::string operator()(const double* field) const { return to_text(*field); }
  std::string operator()(const std::string* field) const { return quoted(*field); }
  std::string operator()(const Eigen::Vector3d* field) const { return to_text(*field); }
  std::string operator()(const std::optional<Eigen::Vector3d>* field) const {
    return to_text(*field);
  }
  std::string operator()(const MountingAngles* field) const { return to_text(*field); }
  template <class Value>
  std::string operator()(const std::map<int, Value>* field) const {
    return to_text(*field);
  }
  template <class Choice>
  std::string operator()(const Choice* field) const {
    return name_of(*field);
  }
};

}  // namespace

bool assign(const ConfigKey& key, const YAML::Node& node) {
  return std::visit(
      [&](auto* field) {
        const auto value = parse(key, node, field);
        if (value) *field = *value;
        return value.has_value();
      },
      key.field);
}

std::string short_range(const ConfigKey& key) {
  std::string choices = std::visit([](auto* field) { return choices_of(field); }, key.field);
  if (!choices.empty()) return choices;
  const auto* range = std::get_if<Range>(&key.allowed);
  if (!range) return "";
  const bool low = std::isfinite(range->minimum);
  const bool high = std::isfinite(range->maximum);
  if (low && high) {
    return (range->above_minimum ? "above " : "") + to_text(range->minimum) + " to " +
           to_text(range->maximum);
  }
  if (low) {
    return range->above_minimum ? "above " + to_text(range->minimum)
                                : to_text(range->minimum) + " or more";
  }
  return high ? to_text(range->maximum) + " or less" : "";
}

std::string expectation(const ConfigKey& key) {
  const std::string range = short_range(key);
  std::string text = std::visit(KindName(), key.field);
  if (const auto* limit = std::get_if<Text>(&key.allowed)) {
    text += " of at most " + std::to_string(limit->max_length) + " characters";
  }
  if (!range.empty()) text += (range.find(" to ") < range.find("above") ? " from " : " ") + range;
  if (!key.unit.empty()) text += " (" + key.unit + ")";
  const auto* limits = std::get_if<Range>(&key.allowed);
  if (limits && *limits->why) text += ", since " + std::string(limits->why);
  return text;
}

std::string value_text(const ConfigKey& key) { return std::visit(ValueText(), key.field); }

std::string node_text(const YAML::Node& node) {
  if (node.IsNull()) return "nothing";
  if (node.IsScalar()) return "\"" + node.Scalar() + "\"";
  if (node.IsMap()) return "a map";
  if (!node.IsSequence()) return "nothing";
  std::string text = "[";
  for (const auto& item : node) text += (text.size() > 1 ? ", " : "") + node_text(item);
  return text + "]";
}

}  // namespace gprodom
