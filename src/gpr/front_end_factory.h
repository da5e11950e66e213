// The front end that a configuration names.
#pragma once

#include <memory>

#include "gprodom/config.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// nullptr for "none". Throws ConfigError on an unknown name.
std::unique_ptr<FrontEnd> make_front_end(const GprConfig& config);

}  // namespace gprodom::gpr
