// Transforms odometry to `map` with the correction that is in force at each time. Poses that were
// already given out are never changed.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "gprodom/outputs.h"
#include "map/path/map_path.h"

namespace gprodom {

class MapFrame {
 public:
  // outputs.odometry in map, one pose for each. A correction is in force from its own time on, or
  // from this call on if odometry has already passed that time.
  std::vector<OdometryEstimate> place(const Outputs& outputs);

  // Sets map = odom, or a correction together with the covariance that the pose in map has now.
  void reset(const std::optional<Correction>& correction = {});

  // The correction in force, with the covariance of the pose in map now. Nothing while map is odom,
  // or before the first pose.
  std::optional<Correction> now() const;

 private:
  std::deque<Correction> waiting_;  // not in force yet
  Correction in_force_;
  OdometryEstimate since_;  // the first estimate that in_force_ placed
  bool corrected_ = false;
  Matrix6d newest_covariance_ = Matrix6d::Zero();  // of the last pose placed, in map
};

// Covariance of x, y, yaw in map of the pose `here`, if that of the pose `since` is `covariance`
// (map axes) and odometry added its own error from there to here. Both poses are in odom.
Eigen::Matrix3d carried_covariance(const Correction& correction, const Eigen::Matrix3d& covariance,
                                   const OdometryEstimate& since, const OdometryEstimate& here);

// A planar state as an estimate, with the fields that carried_covariance() uses.
OdometryEstimate planar_estimate(const PathState& state);

}  // namespace gprodom
