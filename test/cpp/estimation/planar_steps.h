// Steps of a pose graph, for its tests and benchmarks.
#pragma once

#include <Eigen/Core>

#include "estimation/graph/pose_graph.h"

namespace gprodom {

// As odometry of scale 1 takes it. variance: of x, y (m^2) and yaw (rad^2).
inline PlanarStep step_of(const PlanarPose& measured,
                          const Eigen::Vector3d& variance = {4e-5, 1e-5, 4e-6}) {
  PlanarStep step{measured, 1.0, Eigen::Vector3d::Zero(), variance.asDiagonal()};
  step.d_scale.head<2>() = -measured.p;
  return step;
}

}  // namespace gprodom
