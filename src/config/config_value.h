// One configuration value: from YAML into its field, and back into text.
#pragma once

#include <string>

#include "config/config_keys.h"

namespace YAML {
class Node;
}

namespace gprodom {

// Writes `node` into the key's field. Returns false, and leaves the field as it is, if the value
// has the wrong type or is out of range.
bool assign(const ConfigKey& key, const YAML::Node& node);

// The values that the key accepts, as text after "expected": "a number from 0.1 to 10".
std::string expectation(const ConfigKey& key);

// The range in short, for a comment in the YAML file: "0.1 to 10"; empty if there is no limit.
std::string short_range(const ConfigKey& key);

// The field's value as YAML text; doubles in the shortest form that reads back equal.
std::string value_text(const ConfigKey& key);

// A node as text in a message, as an operator would recognise it: "abc", [1, 2], a map.
std::string node_text(const YAML::Node& node);

}  // namespace gprodom
