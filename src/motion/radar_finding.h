// Turns a front end's findings into displacements, as they are published.
#pragma once

#include "gprodom/front_end.h"
#include "gprodom/types.h"

namespace gprodom {

// Of kind kMotion, with a distance of 0.
Displacement to_displacement(const gpr::Standstill& standstill);

// Of kind kMotion, with the scale `metres_per_length`. `sigma_m` stays 0: only the caller knows the
// error of the scale.
Displacement to_displacement(const gpr::PathLength& path, double metres_per_length);

// Of kind kSequential.
Displacement to_displacement(const gpr::TrackDisplacement& measured);

}  // namespace gprodom
