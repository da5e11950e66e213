// Which passes of a track come near a place, and where each comes nearest.
#pragma once

#include <cstddef>
#include <vector>

#include "estimation/graph/pose_graph.h"

namespace gprodom {

struct Pass {
  std::size_t place = 0;  // as offered, the nearest one of the pass
  bool from_before = false;
  double along = 0.0, lateral = 0.0;  // m, from there to the place asked for
  bool turned = false;                // the robot faced the other way
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

  // In the order offered.
  const std::vector<Pass>& passes() const { return passes_; }

 private:
  PlanarPose here_, antenna_;
  double along_m_, aside_m_, farthest_m2_;
  std::vector<Pass> passes_;
  bool on_pass_ = false;  // the last place offered was near
};

// Given in the order driven; those nearest beside the track first. But how far aside passes lie is
// known roughly: second comes the newest of those that are no further aside than `alike_m`, since a
// robot that leaves its track little by little is nearest to where it was last.
std::vector<Pass> in_order_of_promise(std::vector<Pass> passes, double alike_m);

}  // namespace gprodom
