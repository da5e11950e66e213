// Places odometry in `map`: at each time, the map -> odom correction then in force. Poses already
// placed are never rewritten.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "gprodom/outputs.h"

namespace gprodom {

class MapFrame {
 public:
  // outputs.odometry, one for one, in map. A correction is in force from its own time on, or from
  // this call on where odometry has already passed that time.
  std::vector<OdometryEstimate> place(const Outputs& outputs);

  // Back to map = odom; or to a correction with the covariance that the pose in map has now.
  void reset(const std::optional<Correction>& correction = {});

  // The same of now: nothing where map is odom still, or nothing was placed.
  std::optional<Correction> now() const;

 private:
  std::deque<Correction> waiting_;  // their time has not come
  Correction in_force_;
  OdometryEstimate since_;  // the first estimate that in_force_ placed
  bool corrected_ = false;
  Matrix6d newest_covariance_ = Matrix6d::Zero();  // of the last pose placed, in map
};

// Of x, y and yaw: the error of the pose `here` in map where the map's error of the pose `since` is
// `covariance` (map axes), and odometry has added its own from there to here. Both in odom.
Eigen::Matrix3d carried_covariance(const Correction& correction, const Eigen::Matrix3d& covariance,
                                   const OdometryEstimate& since, const OdometryEstimate& here);

// The block of x, y and yaw of a pose covariance; and put in its place, with nothing in common with
// the rest: height, roll and pitch are odometry's, and gravity holds the last two.
Eigen::Matrix3d planar_block(const Matrix6d& covariance);
void set_planar_block(const Eigen::Matrix3d& block, Matrix6d& covariance);

}  // namespace gprodom
