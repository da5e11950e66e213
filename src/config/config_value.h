// One configuration value: from YAML into its field, and back into text.
#pragma once

#include <string>

#include "config/config_keys.h"

namespace YAML {
class Node;
}

namespace gprodom {

// Writes `node` into the key's field. Returns false, with the field untouched, where the value has
// the wrong type or is out of range.
bool assign(const ConfigKey& key, const YAML::Node& node);

// What the key takes, to follow "expected": "a number from 0.1 to 10".
std::string expectation(const ConfigKey& key);

// The range in short, for a comment in the YAML file: "0.1 to 10"; empty where anything goes.
std::string short_range(const ConfigKey& key);

// The field's value as it stands in YAML; doubles in the shortest form that reads back equal.
std::string value_text(const ConfigKey& key);

// A node as an operator would recognise it in a message: "abc", [1, 2], a map.
std::string node_text(const YAML::Node& node);

}  // namespace gprodom
