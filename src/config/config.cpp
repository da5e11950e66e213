#include "gprodom/config.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "base/text.h"
#include "config/config_keys.h"
#include "config/config_value.h"
#include "config/former_keys.h"
#include "gprodom/error.h"

namespace gprodom {
namespace {

std::string section_of(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? std::string() : name.substr(0, dot);
}

std::string leaf_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

// Levenshtein distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

// The known key that the operator most likely meant: one with similar spelling, or one of the same
// name in another section. Empty if there is none.
std::string nearest_key(const std::vector<ConfigKey>& keys, const std::string& name) {
  std::string nearest;
  std::size_t best = std::max<std::size_t>(2, name.size() / 4) + 1;
  for (const auto& key : keys) {
    const std::size_t distance =
        leaf_of(key.name) == leaf_of(name) ? 1 : edit_distance(key.name, name);
    if (distance < best) {
      best = distance;
      nearest = key.name;
    }
  }
  return nearest;
}

std::set<std::string> sections(const std::vector<ConfigKey>& keys) {
  std::set<std::string> names;
  const auto add = [&names](const std::string& key) {
    for (auto s = section_of(key); !s.empty(); s = section_of(s)) names.insert(s);
  };
  for (const auto& key : keys) add(key.name);
  for (const auto& key : removed_keys()) add(key.name);
  for (const auto& key : moved_keys()) add(key.name);
  return names;
}

template <class Key>
const Key* find_key(const std::vector<Key>& keys, const std::string& name) {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

// Whether a node has this value, in any notation.
bool has_value(const YAML::Node& node, const std::string& value) {
  if (!node.IsScalar()) return false;
  if (node.Scalar() == value) return true;
  bool given_bool = false, expected_bool = false;
  if (YAML::convert<bool>::decode(node, given_bool) &&
      YAML::convert<bool>::decode(YAML::Node(value), expected_bool))
    return given_bool == expected_bool;
  double given = 0.0, expected = 0.0;
  return YAML::convert<double>::decode(node, given) &&
         YAML::convert<double>::decode(YAML::Node(value), expected) && given == expected;
}

// Whether the value of a removed key has no effect: it is the fixed value, or the former default.
bool is_default_value(const RemovedKey& key, const YAML::Node& node) {
  return has_value(node, key.value) || (!key.before.empty() && has_value(node, key.before));
}

// Reads YAML into a configuration.
class Loader {
 public:
  explicit Loader(Config& config) : keys_(config_keys(config)), sections_(sections(keys_)) {}

  void read_file(const std::string& path);
  void read_override(const std::string& text);

  // Reports keys that are no longer settings, or have a new name. `where`: the file.
  std::vector<std::string> take_notices(const std::string& where);

 private:
  void assign_key(const std::string& where, const std::string& name, const YAML::Node& node);
  void read_section(const std::string& path, const YAML::Node& map, const std::string& section);
  std::string unknown(const std::string& name) const;

  std::vector<ConfigKey> keys_;
  std::set<std::string> sections_;
  std::vector<std::string> removed_, moved_;  // names, for the notices
};

std::string Loader::unknown(const std::string& name) const {
  if (sections_.count(name)) return "expected a section of keys below it";
  const std::string nearest = nearest_key(keys_, name);
  return nearest.empty() ? "unknown key; config/gprodom.yaml lists all keys"
                         : "unknown key; did you mean " + nearest + "?";
}

std::string at(const std::string& path, const YAML::Mark& mark) {
  return path + ":" + std::to_string(mark.line + 1) + ": ";
}

std::string text_of(const std::string& path) {
  errno = 0;
  std::ifstream file(path);
  std::ostringstream text;
  try {
    if (file && file.peek() != EOF) text << file.rdbuf();
  } catch (const std::ios_base::failure&) {  // a directory, a failing disk
    throw ConfigError(path + ": cannot be read: expected a YAML file");
  }
  if (!file && !file.eof()) {
    throw ConfigError(path + ": cannot be read: " + std::strerror(errno ? errno : EIO));
  }
  return text.str();
}

// The line, from 1, on which a second document begins; 0: none. YAML::LoadAll would find it too,
// but never returns for some text that is not YAML (yaml-cpp 0.7).
int second_document(const std::string& text) {
  std::istringstream lines(text);
  bool in_document = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::string mark = line.substr(0, 3);
    const bool is_mark = (mark == "---" || mark == "...") && (line.size() == 3 || line[3] == ' ');
    if (is_mark && in_document) return number;
    const auto first = line.find_first_not_of(" \t");
    const bool blank = first == std::string::npos || line[first] == '#' || line[0] == '%';
    if (is_mark || !blank) in_document = true;
  }
  return 0;
}

void Loader::read_file(const std::string& path) {
  const std::string text = text_of(path);
  const int second = second_document(text);
  if (second > 0) {
    throw ConfigError(path + ":" + std::to_string(second) + ": expected one YAML document");
  }
  YAML::Node document;
  try {
    document = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ConfigError(at(path, error.mark) + "not YAML: " + error.msg);
  }
  read_section(path, document, "");
}

void Loader::read_section(const std::string& path, const YAML::Node& map,
                          const std::string& section) {
  if (map.IsNull()) return;  // a section with every key commented out
  const std::string prefix = section.empty() ? "" : section + ".";
  if (!map.IsMap()) {
    throw ConfigError(at(path, map.Mark()) + (section.empty() ? "" : section + ": ") +
                      "expected a map of keys, got " + node_text(map));
  }
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) {
      throw ConfigError(at(path, entry.first.Mark()) + "expected a key, got " +
                        node_text(entry.first));
    }
    const std::string name = prefix + entry.first.Scalar();
    const std::string where = at(path, entry.first.Mark()) + name + ": ";
    if (!seen.insert(name).second) throw ConfigError(where + "given twice in this section");
    if (sections_.count(name))
      read_section(path, entry.second, name);
    else
      assign_key(where, name, entry.second);
  }
}

// where: beginning of the error message.
void Loader::assign_key(const std::string& where, const std::string& name, const YAML::Node& node) {
  if (const RemovedKey* removed = find_key(removed_keys(), name)) {
    if (!is_default_value(*removed, node))
      throw ConfigError(where + "no longer a setting: it is fixed at " + removed->value +
                        ", since " + removed->why + "; got " + node_text(node) +
                        ". Delete this key");
    removed_.push_back(name);
    return;
  }
  const MovedKey* moved = find_key(moved_keys(), name);
  const ConfigKey* key = find_key(keys_, moved ? moved->now : name);
  if (!key) throw ConfigError(where + unknown(name));
  if (!assign(*key, node))
    throw ConfigError(where + "expected " + expectation(*key) + ", got " + node_text(node));
  if (moved) moved_.push_back(name + " (now " + moved->now + ")");
}

std::vector<std::string> Loader::take_notices(const std::string& where) {
  std::vector<std::string> notices;
  if (!removed_.empty())
    notices.push_back(where +
                      ": no longer settings; these keys have their default values and can be " +
                      "deleted: " + joined(removed_, ", "));
  if (!moved_.empty()) notices.push_back(where + ": keys with a new name: " + joined(moved_, ", "));
  removed_.clear();
  moved_.clear();
  return notices;
}

void Loader::read_override(const std::string& text) {
  const std::string where = "--set " + text + ": ";
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw ConfigError(where + "expected KEY=VALUE");
  const std::string name = text.substr(0, equals);
  if (sections_.count(name)) throw ConfigError(where + unknown(name));
  YAML::Node value;
  try {
    value = YAML::Load(text.substr(equals + 1));
  } catch (const YAML::Exception& error) {
    throw ConfigError(where + "not YAML: " + error.msg);
  }
  assign_key(where, name, value);
}

// Those of channels, without the prefix.
std::vector<ConfigKey> channel_keys(Config& config) {
  std::vector<ConfigKey> channels;
  for (const ConfigKey& key : config_keys(config))
    if (section_of(key.name) == "channels" && leaf_of(key.name) != "prefix")
      channels.push_back(key);
  return channels;
}

// Puts the prefix before each name that has its default value.
void put_prefix(Config& config) {
  Config defaults;
  const auto keys = channel_keys(config), usual = channel_keys(defaults);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::string& name = *std::get<std::string*>(keys[i].field);
    if (name == *std::get<std::string*>(usual[i].field)) name = config.channels.prefix + name;
  }
}

// Messages of two types on the same channel could not be distinguished. `where`: the files, or
// empty.
void check_channels(Config& config, const std::string& where) {
  std::map<std::string, std::string> owner;
  for (const ConfigKey& key : channel_keys(config)) {
    const std::string& channel = *std::get<std::string*>(key.field);
    const auto [other, is_new] = owner.emplace(channel, key.name);
    if (!is_new) {
      throw ConfigError(where + key.name + ": expected a channel of its own, got \"" + channel +
                        "\", which is " + other->second);
    }
  }
}

// An offset of an antenna whose traces are refused would do nothing.
void check_time_offsets(const GprConfig& gpr, const std::string& where) {
  for (const auto& [id, offset_s] : gpr.time_offsets)
    if (!gpr.antennas.empty() && !gpr.antennas.count(id))
      throw ConfigError(where + "gpr.time_offsets: expected antennas that gpr.antennas has, got " +
                        std::to_string(id));
}

}  // namespace

Config load_config(const std::vector<std::string>& paths, const std::vector<std::string>& overrides,
                   std::vector<std::string>* notices) {
  Config config;
  Loader loader(config);
  const auto tell = [&](const std::vector<std::string>& told) {
    if (notices) notices->insert(notices->end(), told.begin(), told.end());
  };
  std::string where;
  for (const auto& path : paths) {
    loader.read_file(path);
    where += path + ": ";
    tell(loader.take_notices(path));
  }
  for (const auto& text : overrides) loader.read_override(text);
  tell(loader.take_notices("--set"));
  put_prefix(config);
  if (!config.gpr.antennas.empty()) config.gpr.lever_arm = config.gpr.antennas.begin()->second;
  check_channels(config, where);
  check_time_offsets(config.gpr, where);
  return config;
}

Config default_config(const std::vector<std::string>& overrides) {
  return load_config({}, overrides);
}

std::vector<ConfigChange> differences(const Config& before, const Config& after) {
  Config old_config = before;
  Config new_config = after;
  const auto old_keys = config_keys(old_config);
  const auto new_keys = config_keys(new_config);
  std::vector<ConfigChange> changes;
  for (std::size_t i = 0; i < old_keys.size(); ++i) {
    const std::string was = value_text(old_keys[i]);
    const std::string is = value_text(new_keys[i]);
    if (was != is) changes.push_back({old_keys[i].name, was, is});
  }
  return changes;
}

namespace {

// Opens the sections of `name` that are not open in `open`, one line each.
void write_section_heads(const std::string& name, std::string& open, std::string& text) {
  const std::string section = section_of(name);
  if (section == open) return;
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1)) {
    const std::string head = name.substr(0, dot);
    if (open == head || open.rfind(head + ".", 0) == 0) continue;
    const std::string indent(2 * std::count(head.begin(), head.end(), '.'), ' ');
    const std::string description = section_description(head);
    if (indent.empty()) text += '\n';
    if (!description.empty()) text += indent + "# " + description + "\n";
    text += indent + leaf_of(head) + ":\n";
  }
  open = section;
}

std::string comment(const ConfigKey& key) {
  std::string head = key.unit;
  const std::string range = short_range(key);
  if (!range.empty()) head += (head.empty() ? "" : ", ") + range;
  return head.empty() ? key.description : head + ": " + key.description;
}

}  // namespace

std::string describe_config(const Config& config) {
  Config copy = config;
  std::string text =
      "# Every setting of gprodom with unit, range and meaning; written by `gprodomd\n"
      "# --print-config`. A file for -c needs only the keys that differ from the defaults, which\n"
      "# config/gprodom.yaml has. If several files are given, later ones override earlier ones.\n";
  std::string open;
  for (const auto& key : config_keys(copy)) {
    write_section_heads(key.name, open, text);
    std::string line(2 * std::count(key.name.begin(), key.name.end(), '.'), ' ');
    line += leaf_of(key.name) + ": " + value_text(key);
    if (line.size() < 32) line.resize(32, ' ');
    text += line + "  # " + comment(key) + "\n";
  }
  return text;
}

}  // namespace gprodom
