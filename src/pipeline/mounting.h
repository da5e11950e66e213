// imu.rpy_body_imu: auto. docs/estimation.md, "A wrong mounting".
#pragma once

#include <Eigen/Core>
#include <optional>

#include "estimation/state_estimator.h"
#include "gprodom/config.h"
#include "input/mounting_watch.h"

namespace gprodom {

// Of roll, pitch, yaw (rad): Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rpy);
Eigen::Vector3d rpy_of(const Eigen::Matrix3d& R);

// Roll, pitch, yaw (rad) of the configuration or, with auto, as found earlier; or zeros.
Eigen::Vector3d mounting_at_first(const Config& config, const std::optional<FoundMounting>& found);

// The same in which no acceleration is taken for a slip of the wheel.
Config without_accelerations(Config config);

// A state as it is with other body axes. R takes the old ones to them. The robot's place stays, and
// the wheel's direction in odom: the path along it was right.
StateResult in_other_axes(StateResult result, const Eigen::Matrix3d& R);

}  // namespace gprodom
