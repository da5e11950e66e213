// Errors that end a command with one line: what is wrong, where, and what was expected.
#pragma once

#include <stdexcept>
#include <string>

namespace gprodom {

struct ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct FileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace gprodom
