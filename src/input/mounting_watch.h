// Checks imu.rpy_body_imu, the configured mounting of the IMU, against gravity, the axis of the
// robot's turns and the wheel's speed; docs/estimation.md, "A wrong mounting".
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "input/mounting_windows.h"

namespace gprodom {

class MountingWatch {
 public:
  // As MountingWindows::add().
  void add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
           const Eigen::Vector3d& gyro_bias);

  // What is wrong and what to do about it; empty if nothing is found.
  const std::string& trouble() const { return trouble_; }

 private:
  // Of some seconds; sums over their windows.
  struct Block {
    double across = 0.0, along = 0.0;  // of accelerations: turned from the wheel's; as the wheel's
    Eigen::Vector2d turned = Eigen::Vector2d::Zero();   // rates about x and y, times that about z
    double turned_up = 0.0;                             // rate about z, squared
    Eigen::Vector2d leaning = Eigen::Vector2d::Zero();  // gravity along x and y, over that along z
  };
  // An angle with its standard deviation (rad), estimated from many blocks.
  struct Angle {
    double value = 0.0, sigma = 0.0;
    bool beyond(double limit, double sigmas) const;
  };

  void close_block();
  Angle turned_about_up() const;
  Angle axis_along(const Eigen::Vector2d& direction) const;
  std::string judge() const;

  MountingWindows windows_;
  std::deque<Block> blocks_;
  double gravity_off_ = 0.0;  // rad, of late
  std::string trouble_;
};

}  // namespace gprodom
