// What a radar front end says of motion, as it is published.
#pragma once

#include "gprodom/front_end.h"
#include "gprodom/types.h"

namespace gprodom {

// As kMotion: no motion is a distance of 0.
Displacement to_displacement(const gpr::Standstill& standstill);

// As kMotion, `metres_per_length` being the scale. The caller knows the errors of that, and whether
// it is known at all: `sigma_m` is left 0.
Displacement to_displacement(const gpr::PathLength& path, double metres_per_length);

// As kSequential.
Displacement to_displacement(const gpr::TrackDisplacement& measured);

}  // namespace gprodom
