// The configuration of a program that is given none with -c.
#pragma once

#include <string>
#include <vector>

namespace gprodom {

// `paths` if there are any. Otherwise what `gprodom run` takes, too: the robot's own file where the
// program is installed and there is one, else none, which stands for the defaults.
std::vector<std::string> or_default(std::vector<std::string> paths);

}  // namespace gprodom
