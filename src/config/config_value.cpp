#include "config/config_value.h"

#include <yaml-cpp/yaml.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

namespace gprodom {
namespace {

std::string to_text(bool value) { return value ? "true" : "false"; }

std::string to_text(int value) { return std::to_string(value); }

std::string to_text(double value) {
  std::array<char, 32> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string to_text(const std::string& text) {
  YAML::Emitter emitter;
  emitter << text;  // with quotes if YAML needs them
  return emitter.c_str();
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

template <class Choice>
std::string to_text(Choice choice) {
  return name_of(choice);
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

// One overload for each type of field. Returns false, and leaves the field as it is, if the node
// does not fit. This one is for numbers, and for enums by the names of their values.
template <class Value>
bool read(const ConfigKey& key, const YAML::Node& node, Value& field) {
  if (!node.IsScalar()) return false;
  std::optional<Value> value;
  if constexpr (std::is_enum_v<Value>) {
    value = find_choice<Value>(node.Scalar());
  } else {
    value = parse_number<Value>(node.Scalar());
    if (value && !within(std::get<Range>(key.allowed), double(*value))) return false;
  }
  if (value) field = *value;
  return value.has_value();
}

bool read(const ConfigKey& /*key*/, const YAML::Node& node, bool& field) {
  return node.IsScalar() && YAML::convert<bool>::decode(node, field);
}

bool read(const ConfigKey& key, const YAML::Node& node, std::string& field) {
  const auto& limit = std::get<Text>(key.allowed);
  if (!node.IsScalar() || (node.Scalar().empty() && !limit.may_be_empty)) return false;
  if (node.Scalar().size() > limit.max_length) return false;
  field = node.Scalar();
  return true;
}

bool read(const ConfigKey& key, const YAML::Node& node, Eigen::Vector3d& field) {
  if (!node.IsSequence() || node.size() != 3) return false;
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i)
    if (!read(key, node[i], vector[i])) return false;
  field = vector;
  return true;
}

// none: the node says that there is no vector.
bool read(const ConfigKey& key, const YAML::Node& node, bool none,
          std::optional<Eigen::Vector3d>& field) {
  Eigen::Vector3d vector;
  if (!none && !read(key, node, vector)) return false;
  field = none ? std::nullopt : std::optional(vector);
  return true;
}

bool read(const ConfigKey& key, const YAML::Node& node, std::optional<Eigen::Vector3d>& field) {
  return read(key, node, node.IsSequence() && node.size() == 0, field);
}

bool read(const ConfigKey& key, const YAML::Node& node, MountingAngles& field) {
  return read(key, node, node.IsScalar() && node.Scalar() == "auto", field.rpy);
}

template <class Value>
bool read(const ConfigKey& key, const YAML::Node& node, std::map<int, Value>& field) {
  if (!node.IsMap()) return false;
  std::map<int, Value> by_antenna;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) return false;
    const auto id = parse_number<int>(entry.first.Scalar());
    Value value;
    if (!id || !read(key, entry.second, value) || !by_antenna.emplace(*id, value).second)
      return false;
  }
  field = std::move(by_antenna);
  return true;
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

}  // namespace

bool assign(const ConfigKey& key, const YAML::Node& node) {
  return std::visit([&](auto* field) { return read(key, node, *field); }, key.field);
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

std::string value_text(const ConfigKey& key) {
  return std::visit([](const auto* field) { return to_text(*field); }, key.field);
}

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
