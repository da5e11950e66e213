// The instance number of the estimator that sent a STATUS, so that two estimators on the same
// channels notice each other.
#pragma once

#include <cstddef>
#include <optional>

namespace gprodom {

// The instance number in a packet of status_t; 0 if it has none, nothing if the packet is not a
// complete message of that type. See kInstance in gprodom/types.h.
std::optional<double> instance_of(const void* data, std::size_t size);

}  // namespace gprodom
