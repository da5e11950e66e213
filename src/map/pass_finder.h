// Finds the passes of a track near a place, and the nearest place of each pass.
#pragma once

#include <cstddef>
#include <vector>

#include "estimation/graph/pose_graph.h"

namespace gprodom {

struct Pass {
  std::size_t place = 0;  // number of the nearest place of the pass, as given to offer()
  bool from_before = false;
  double along = 0.0, lateral = 0.0;  // m, from there to `here`
  bool turned = false;                // with the opposite heading
};

class PassFinder {
 public:
  // here: pose of the antenna. A place is near if its antenna was at most `along_m` ahead or behind
  // and `aside_m` aside, on a track parallel to `here` in either direction. arm_m: no antenna is
  // further from the body's origin.
  PassFinder(const PlanarPose& here, double along_m, double aside_m, double arm_m);

  // In the order driven: whether a place may be near, by the body's pose alone; and if so, the pose
  // of its antenna.
  bool may_be_near(const PlanarPose& body);
  void offer(std::size_t place, const PlanarPose& antenna, bool from_before);
  // The next place does not continue the track of the last one.
  void interrupt() { on_pass_ = false; }

  // In the order of offer().
  const std::vector<Pass>& passes() const { return passes_; }

 private:
  PlanarPose here_;
  double along_m_, aside_m_, farthest_m2_;
  std::vector<Pass> passes_;
  bool on_pass_ = false;  // the last place offered was near
};

// Sorts passes, which are given in the order driven, by lateral offset. But the offsets are known
// only roughly: the second place goes to the newest pass with an offset up to `alike_m`, since a
// robot that slowly leaves its track is nearest to its last pass.
std::vector<Pass> in_search_order(std::vector<Pass> passes, double alike_m);

}  // namespace gprodom
