// What a function expects of its arguments.
#pragma once

#include <stdexcept>

namespace gprodom {

// Throws std::invalid_argument.
inline void require(bool holds, const char* expected) {
  if (!holds) throw std::invalid_argument(expected);
}

}  // namespace gprodom
