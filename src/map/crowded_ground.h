// Ground that is driven again and again: passes that lie side by side so densely that one more
// would see nothing new.
#pragma once

#include <vector>

#include "map/ground_map.h"
#include "map/pass_finder.h"

namespace gprodom {

// Whether so many of the passes lie within kLateralGate of here that an antenna's footprint
// (`lateral_sigma_m`) among them is covered.
bool is_crowded(const std::vector<Pass>& passes, double lateral_sigma_m);

// The ground without the stretches beside which enough older passes of the same map are stored, one
// of them within a footprint. A track stores such a stretch where it does not know yet which passes
// lie beside it. Only stretches
// that are long enough to be searched are left out, and pieces between them that are too short to
// be searched. The descent of the ground stays, as where passes are merged.
GroundMap without_crowded(GroundMap ground, double lateral_sigma_m);

}  // namespace gprodom
