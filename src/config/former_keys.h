// Keys of earlier versions: their configuration files can still be read, and keys that are no
// longer settings are reported.
#pragma once

#include <string>
#include <vector>

namespace gprodom {

// No longer a setting, since the value is the same for every robot.
struct RemovedKey {
  std::string name;
  std::string value;  // the fixed value
  std::string why;    // reason why nobody needs to set it
  // Its default in version 0.1 if that differs: a file may still have it.
  std::string before = {};
};

// The same setting under another name.
struct MovedKey {
  std::string name, now;
};

const std::vector<RemovedKey>& removed_keys();
const std::vector<MovedKey>& moved_keys();

}  // namespace gprodom
