// Finds how the track of one drive lies on the ground of another, by the ground that both drove
// over: a place found anywhere is a hypothesis, the revisits that follow from it tie both tracks in
// one pose graph. docs/map_format.md, "Two sessions become one".
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "gpr/revisit/revisit_search.h"
#include "gprodom/config.h"
#include "map/change_follower.h"
#include "map/ground_map.h"
#include "map/locator.h"

namespace gprodom {

// Of two tracks, ground that both drove over.
struct Revisited {
  std::size_t column = 0;  // at the middle of the patch, of the track that joins
  bool trusted = false;    // by the solution over both
};

struct JoinedTracks {
  std::vector<Revisited> revisits;
  double proven_m = 0.0;           // driven over patches that trusted revisits found
  gpr::TraceChange change;         // of the track that joins since the other
  std::vector<KnownPlace> places;  // of both tracks, in the frame of the other
  PlanarEstimate end;              // the last place of the track that joins, and its covariance

  bool proven(const GraphConfig& config) const;
};

class MapJoiner {
 public:
  // ground: columns from `begin` on are those of tracks that may join; what is before is searched.
  // Its places are poses of the antenna.
  MapJoiner(const GroundMap& ground, std::size_t begin, const GraphConfig& config);

  // The track of that map, with these stored runs, joins another one: what is known if that is
  // proven, else the best of what was tried; nothing if no place was found.
  std::optional<JoinedTracks> join(int map, const std::vector<gpr::MemoryRange>& runs);

 private:
  const GroundMap& ground_;
  const std::size_t begin_;
  const GraphConfig config_;
  Locator locator_;
};

}  // namespace gprodom
