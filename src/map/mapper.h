// SLAM back end. It stores the ground driven over, searches it for the newest ground, and adds each
// revisit found (loop closure) to the pose graph of the track. After a reset, a revisit on older
// ground ties the track to the map of an earlier track. Runs in jobs of one worker thread.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/types.h"
#include "map/ground_map.h"
#include "map/ground_search.h"
#include "map/ground_store.h"
#include "map/map_answer.h"
#include "map/relocation.h"
#include "map/site_tie.h"
#include "map/track_graph.h"

namespace gprodom {

class Mapper {
 public:
  // before: the ground of earlier tracks. start: how this track lies in one of their maps.
  Mapper(const Config& config, std::optional<GroundMap> before, std::optional<TrackStart> start);
  Mapper(const Mapper&) = delete;  // its parts refer to each other
  Mapper& operator=(const Mapper&) = delete;

  MapAnswer run(const MapInput& input);

  // Call before the first run(): keeps all revisits for the track's revisits().
  void record() { track_.record(); }
  const TrackGraph& track() const { return track_; }
  // Of this track, in time order; none before they have tied it to site.
  std::vector<UsedFix> used_fixes() const { return site_.used_fixes(); }

  // As GroundStore has them.
  SavedGround saved_ground(bool main);
  SavedGround newest_ground();
  GroundMap take_ground();
  GroundMap take_earlier_ground();

 private:
  void use_external(MapAnswer& answer);
  void use_found(const GroundSearch::Found& found, MapAnswer& answer);
  Sighting sighting(const GroundSearch::Found& found, const RevisitEnd& memory) const;
  bool use(const Sighting& seen, MapAnswer& answer);
  void join(Relocation::Candidate proved, MapAnswer& answer);
  void join_map(const Hypothesis& at);

  const GraphConfig config_;
  std::optional<int> starts_in_;  // number of a map, until there is a state
  TrackGraph track_;
  GroundStore store_;
  SiteTie site_;
  Relocation relocation_;
  GroundSearch search_;
  std::deque<Displacement> external_;  // revisits of another process, to wait for settled states
};

}  // namespace gprodom
