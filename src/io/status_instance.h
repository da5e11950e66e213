// Which estimator says a STATUS: two on the same channels must notice each other.
#pragma once

#include <cstddef>
#include <optional>

namespace gprodom {

// The instance number in a packet of status_t, 0 where it has none; nothing where the packet is not
// a whole message of that type. See kInstance in gprodom/types.h.
std::optional<double> instance_of(const void* data, std::size_t size);

}  // namespace gprodom
