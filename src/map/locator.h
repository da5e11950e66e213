// Where a track that begins anywhere lies on ground remembered from before: asked of all of it
// (gpr/global_search.h) every few metres, until the revisits that the answer foretells are found.
// docs/revisit.md, "After a reset".
#pragma once

#include <optional>

#include "gpr/revisit/global_search.h"
#include "gprodom/config.h"
#include "map/ground_map.h"

namespace gprodom {

// How the track may lie in a map.
struct Hypothesis {
  PlanarPose map_from_track;
  int map = 0;
};

class Locator {
 public:
  Locator(const GraphConfig& config, const PlanarPose& antenna_in_body);

  // A search is due after so much driven.
  bool is_due(double travelled_m) const { return travelled_m >= next_m_; }

  // Compares the kept part of the run under way, columns from `end_of_before` on, with the ground
  // before that column. newest_body: the robot, in the track's frame, over the last column kept.
  std::optional<Hypothesis> look(const GroundMap& ground, std::size_t end_of_before,
                                 const PlanarPose& newest_body, double travelled_m);

 private:
  void learn(const GroundMap& ground, std::size_t end_of_before);

  const GraphConfig config_;
  const PlanarPose antenna_;
  double next_m_ = 0.0;
  std::optional<gpr::GlobalSearch> search_;
};

}  // namespace gprodom
