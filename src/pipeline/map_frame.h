// Places odometry in `map`: at each time, the map -> odom correction then in force. Poses already
// placed are never rewritten.
#pragma once

#include <deque>
#include <vector>

#include "gprodom/odometry.h"

namespace gprodom {

class MapFrame {
 public:
  // outputs.odometry, one for one, in map. A correction is in force from its own time on, or from
  // this call on where odometry has already passed that time.
  std::vector<OdometryEstimate> place(const Outputs& outputs);

  // Back to map = odom.
  void reset();

 private:
  std::deque<Correction> waiting_;  // their time has not come
  Correction in_force_;
};

// One estimate in map, with `correction` in force. Covariances add as if the two errors were
// independent, since the correction's cross covariance with later odometry is not carried.
OdometryEstimate in_map(const Correction& correction, const OdometryEstimate& estimate);

}  // namespace gprodom
