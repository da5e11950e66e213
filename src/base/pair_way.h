// What the estimator and antennas in a row tell each other: the way driven, and passages over it.
#pragma once

#include <Eigen/Core>

#include "gprodom/types.h"

namespace gprodom {

// How far the robot had gone along its track, signed, and turned about its z; both from any origin.
struct WayPoint {
  TimeNs time = 0;
  double s_m = 0.0;
  double heading_rad = 0.0;  // not wrapped
};

// One antenna was at time `to` where another had been at time `from`.
struct AntennaPassage {
  TimeNs from = 0, to = 0;
  Eigen::Vector3d lever_from = Eigen::Vector3d::Zero();  // m, in body
  Eigen::Vector3d lever_to = Eigen::Vector3d::Zero();
  double sigma_m = 0.0;  // along the track, without that of the antennas' distance
  // Displacement along the track that the antennas' distance says, signed, m.
  double distance_m() const { return (lever_from - lever_to).x(); }
};

}  // namespace gprodom
