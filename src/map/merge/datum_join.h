// How the track of one map lies on that of another by where both lie in site.
#pragma once

#include <optional>

#include "map/ground_map.h"
#include "map/merge/map_joiner.h"

namespace gprodom {

// The track of map `joining` joins one of a map below `begin`, by the datums of both, where no
// place is so uncertain that a drive from the one to the other would not find its ground again.
std::optional<JoinedTracks> join_by_datum(const GroundMap& ground, int joining, int begin);

// Of a join by ground: how far it is from what the datums of both say, at the joining track's end.
struct DatumCheck {
  double off_m = 0.0;
  double deviations = 0.0;  // of position and heading, in standard deviations
  bool agrees() const;
};
// Nothing where not both lie in one site. joining: of a map whose places are as they were.
std::optional<DatumCheck> check_datums(const GroundMap& ground, int joining,
                                       const JoinedTracks& joined);

// Where the other map of a join by ground lies in site, by the datum of the one that joins it.
// Nothing without that.
std::optional<MapDatum> datum_of_other(const GroundMap& ground, int joining,
                                       const JoinedTracks& joined);

}  // namespace gprodom
