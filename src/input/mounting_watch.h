// Checks imu.rpy_body_imu, the configured mounting of the IMU, against gravity, the axis of the
// robot's turns and the wheel's speed, and finds it where it is not configured (auto);
// docs/estimation.md, "A wrong mounting".
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "estimation/recent_motion.h"

namespace gprodom {

// imu.rpy_body_imu as it was found; saved for the next run.
struct FoundMounting {
  Eigen::Vector3d rpy_body_imu = Eigen::Vector3d::Zero();  // rad
  double yaw_sigma = 0.0;                                  // rad
};

class MountingWatch {
 public:
  // An interval that follows the one before. steps: IMU in body axes. wheel_m: the wheel's distance
  // (signed) at its end; nothing where it is not known.
  void add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
           const Eigen::Vector3d& gyro_bias);

  // What is wrong and what to do about it; empty if nothing is found.
  const std::string& trouble() const { return trouble_; }

  // How the IMU is turned beyond the mounting that gave the steps.
  struct Turn {
    Eigen::Matrix3d R;       // takes the steps' axes to the robot's
    double yaw_sigma = 0.0;  // rad
    bool usable = false;     // better than not knowing it
  };
  // Nothing before there is a block.
  std::optional<Turn> turn() const;
  // From here on the steps come in these axes.
  void turned(const Eigen::Matrix3d& R);

 private:
  // Means over a half to a whole second.
  struct Window {
    double seconds = 0.0;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // m/s^2
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();   // rad/s, less the bias
    double speed = 0.0;                               // m/s, by the wheel
    bool wheel = true;                                // it is known
  };
  // Of some seconds; sums over their windows.
  struct Block {
    double across = 0.0, along = 0.0;  // of accelerations: turned from the wheel's; as the wheel's
    double by_wheel = 0.0, by_imu = 0.0;  // squares of either
    // Sums over the windows of the squares of (along, across), and of their product.
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    Eigen::Vector2d turned = Eigen::Vector2d::Zero();   // rates about x and y, times that about z
    double turned_up = 0.0;                             // rate about z, squared
    Eigen::Vector2d leaning = Eigen::Vector2d::Zero();  // gravity along x and y, over that along z
  };
  // An angle with its standard deviation (rad), estimated from many blocks.
  struct Angle {
    double value = 0.0, sigma = 0.0;
    bool beyond(double limit, double sigmas) const;
  };

  void close_window(std::optional<double> wheel_m);
  void close_block();
  Angle turned_about_up() const;
  Angle axis_along(const Eigen::Vector2d& direction) const;
  Eigen::Vector2d leaning() const;
  bool leans(const Eigen::Vector2d& lean) const;
  std::string judge() const;

  Window open_;
  std::optional<double> wheel_m_;  // at the open window's beginning
  std::vector<Window> windows_;
  std::deque<Block> blocks_;
  double gravity_off_ = 0.0;  // rad, of late
  std::string trouble_;
};

}  // namespace gprodom
