// Errors that end a command with one line: what is wrong, where, and what was expected.
#pragma once

#include <stdexcept>
#include <string>

#include "gprodom/export.h"

namespace gprodom {

struct GPRODOM_EXPORT ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct GPRODOM_EXPORT FileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace gprodom
