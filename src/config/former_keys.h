// Keys of earlier versions, so that their configuration files are still read, and what a file says
// that is no longer a setting is told.
#pragma once

#include <string>
#include <vector>

namespace gprodom {

// No longer a setting: the value is the same for every robot.
struct RemovedKey {
  std::string name;
  std::string value;  // at which it is fixed
  std::string why;    // nobody needs to set it
  // Its default in 0.1, where that was another: a file may still have it.
  std::string before = {};
};

// The same setting under another name.
struct MovedKey {
  std::string name, now;
};

const std::vector<RemovedKey>& removed_keys();
const std::vector<MovedKey>& moved_keys();

}  // namespace gprodom
