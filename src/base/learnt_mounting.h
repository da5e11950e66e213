// How the IMU is mounted, as a drive has shown it.
#pragma once

#include <Eigen/Geometry>

namespace gprodom {

struct LearntMounting {
  Eigen::Quaterniond q_body_imu = Eigen::Quaterniond::Identity();
  double yaw_sigma = 0.0;  // rad
};

}  // namespace gprodom
