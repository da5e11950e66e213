// What a radar's own unit of motion, such as a decorrelation length of the ground, is in metres:
// learned while wheel and IMU agree.
#pragma once

#include <deque>

#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/path_history.h"

namespace gprodom {

// x = ln(metres / lengths) of each span over which the published estimates are sound: moving, wheel
// in use, no slip within half a second of it (a slip is flagged late). Mean of x over the last
// `scale_distance` metres, weighted by distance; variance from what each new x was off that mean,
// over four times that distance, beginning with that of a guess. Neighbouring spans lie on the same
// ground and err alike, so the variance told is twice that of one span; it doubles over eight times
// `scale_distance` driven without learning.
class CoherenceScale {
 public:
  explicit CoherenceScale(const CoherenceConfig& config);

  // Every estimate published, in time order. `speed_known`: it can be learnt from.
  void add(const OdometryEstimate& estimate, bool speed_known);

  void learn_from(const gpr::PathLength& path);

  // The same in metres, as a kMotion displacement, with `scale` the metres per length; not valid
  // before half of `scale_distance` has been learned from.
  Displacement to_metres(const gpr::PathLength& path);

  double metres_per_length() const;  // 0 while unknown
  double relative_sigma() const;     // of a span's distance

 private:
  bool sound(TimeNs from, TimeNs to) const;
  void learn(const gpr::PathLength& path);

  CoherenceConfig config_;
  PathHistory track_;                    // unsigned, as published
  std::deque<TimeNs> unsound_;           // estimates not to be learned from, oldest first
  std::deque<gpr::PathLength> waiting_;  // spans to learn from
  double learned_m_ = 0.0, blind_m_ = 0.0;
  double weight_ = 0.0, sum_ = 0.0;  // m; of x
  double variance_weight_ = 0.0, variance_sum_ = 0.0;
};

}  // namespace gprodom
