// Ground that is neither the map's nor on disk: of an estimator that has failed, until the next one
// has started, and of other settings of the radar.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "gprodom/types.h"
#include "map/ground_map.h"

namespace gprodom {

struct Rescue {
  bool begun = false;               // the failed estimator has given its ground away
  std::optional<GroundMap> ground;  // of it; nothing where there was none or it is at fault
  std::deque<TimeNs> map_failures;  // data times
  std::vector<GroundMap> unsaved;   // of other settings of the radar; one each
};

}  // namespace gprodom
