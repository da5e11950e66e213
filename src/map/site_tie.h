// Positions from outside tie the track, and the ground that it lies on, to `site`. docs/anchors.md.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/position_fix.h"
#include "map/fixes/fix_keeper.h"
#include "map/fixes/map_datum.h"
#include "map/ground_store.h"
#include "map/map_answer.h"
#include "map/track_graph.h"

namespace gprodom {

class SiteTie {
 public:
  // Both outlive this.
  SiteTie(const AnchorConfig& config, TrackGraph& track, GroundStore& store);

  // Returns true if `map` has become `site` by these fixes.
  bool take(const MapInput& input, std::vector<std::string>& notes);
  // The trusted fixes as edges at the nodes that the track has now.
  void place_fixes();
  // Where the map lies in site, for its file. Ground that has told this itself keeps it: it does
  // not move with what this track's fixes say beside it.
  void note_datum();

  std::optional<FixReport> report() const;  // from the first fix on
  // In time order; none before they have tied the track to site.
  std::vector<UsedFix> used_fixes() const;

 private:
  struct Tie {
    PlanarPose by;                  // moves what is in map to site
    Eigen::Matrix3d first;          // covariance of the first node there, beside the fixes
    std::optional<MapDatum> datum;  // of the ground that the track lies on, if that tells `by`
  };
  void take_datums();
  bool tie(const ScaleKnown& scale, std::vector<std::string>& notes);
  std::optional<Tie> tie_by_ground() const;
  std::optional<Tie> tie_by_fixes() const;
  std::vector<PlanarPose> places_of_fixes(const PlanarPose& site_from_map) const;

  TrackGraph& track_;
  GroundStore& store_;
  FixKeeper fixes_;
  std::deque<PositionFix> waiting_;  // for settled states, in time order
  bool keeps_datum_ = false;         // tied by that of the ground, which stays what it was
};

}  // namespace gprodom
