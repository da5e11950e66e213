// The front end that a configuration asks for.
#pragma once

#include <memory>

#include "gprodom/config.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// nullptr for kNone. Throws ConfigError where settings contradict each other.
std::unique_ptr<FrontEnd> make_front_end(const GprConfig& config);

}  // namespace gprodom::gpr
