// Learns the length in metres of the radar's own unit of motion, such as a decorrelation length of
// the ground, while wheel and IMU agree.
#pragma once

#include <deque>

#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "motion/history/path_history.h"

namespace gprodom {

// Each span gives x = ln(metres / lengths) if the published estimates over it can be used: the
// robot moves, the wheel is in use, and there is no slip within half a second (slip is flagged
// late). The result is the mean of x over the last `kLearntOver` metres, weighted by distance.
// The variance is that of each new x about the mean, over four times that distance, and starts from
// a prior. Neighbouring spans lie on the same ground and their errors are correlated, so the
// variance given is twice that of one span. It doubles over eight times `kLearntOver` without
// learning.
class CoherenceScale {
 public:
  // m; the ground changes from place to place, and a scale of fewer spans would scatter more.
  static constexpr double kLearntOver = 5.0;

  CoherenceScale();

  // Call with every published estimate, in time order. `speed_known`: it can be learnt from.
  void add(const OdometryEstimate& estimate, bool speed_known);

  void learn_from(const gpr::PathLength& path);

  // A path length in metres, as a kMotion displacement whose `scale` is the metres per length. Not
  // valid until half of `kLearntOver` has been learnt from.
  Displacement to_metres(const gpr::PathLength& path);

  double metres_per_length() const;  // 0 while unknown
  double relative_sigma() const;     // of a span's distance

 private:
  void begin_unit(int unit);
  bool usable(TimeNs from, TimeNs to) const;
  void learn(const gpr::PathLength& path);

  PathHistory track_;                    // unsigned, as published
  std::deque<TimeNs> unusable_;          // times of estimates not to learn from, oldest first
  std::deque<gpr::PathLength> waiting_;  // spans to learn from
  int unit_ = 0;
  double learned_m_ = 0.0;           // learnt from so far
  double unlearned_m_ = 0.0;         // driven since without learning
  double weight_ = 0.0, sum_ = 0.0;  // m; of x
  double variance_weight_ = 0.0, variance_sum_ = 0.0;
};

}  // namespace gprodom
