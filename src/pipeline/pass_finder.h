// Which passes of a track come near a place, and where each comes nearest.
#pragma once

#include <cstddef>
#include <vector>

#include "gprodom/pose_graph.h"

namespace gprodom {

struct Pass {
  std::size_t place = 0;  // as offered, the nearest one of the pass
  bool from_before = false;
  double along = 0.0, lateral = 0.0;  // m, from there to the place asked for
};

class PassFinder {
 public:
  // here: pose of the antenna. Places up to `along_m` before or behind and `aside_m` beside it, on
  // a track parallel to it either way, are near.
  PassFinder(const PlanarPose& here, const PlanarPose& antenna_in_body, double along_m,
             double aside_m);

  // Poses of the body, in the order driven.
  void offer(std::size_t place, const PlanarPose& body, bool from_before);
  // What is offered next does not go on from the last one.
  void interrupt() { on_pass_ = false; }

  // Those nearest beside the track first.
  std::vector<Pass> nearest_first() const;

 private:
  PlanarPose here_, antenna_;
  double along_m_, aside_m_, farthest_m2_;
  std::vector<Pass> passes_;
  bool on_pass_ = false;  // the last place offered was near
};

}  // namespace gprodom
