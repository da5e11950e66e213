// Two map files become one: docs/map_format.md, "Two sessions become one".
#pragma once

#include <optional>
#include <vector>

#include "gprodom/config.h"
#include "map/ground_map.h"
#include "map/merge/datum_join.h"
#include "map/merge/map_joiner.h"

namespace gprodom {

// Of a map of the second file.
struct MapJoin {
  int map = 0;                         // its number there
  bool proven = false;                 // else it is left out
  int into = 0;                        // number of the map of the first file, if proven
  std::optional<JoinedTracks> joined;  // by poses of the body; nothing if no place was found
  bool by_datum = false;               // proven by where both lie in site, not by ground
  std::optional<DatumCheck> check;     // of a join by ground, where both lie in site
};

struct MergedMaps {
  GroundMap ground;  // the first file's if no join is proven
  std::vector<MapJoin> joins;
  double known_m = 0.0;  // of the second file's ground, left out since the first file has it
};

// Throws std::invalid_argument if the files cannot be compared, or are too long together.
MergedMaps merge_maps(const GroundMap& first, const GroundMap& second, const GraphConfig& config);

}  // namespace gprodom
