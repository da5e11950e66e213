// Finds how the IMU is mounted (imu.rpy_body_imu: auto), or whether the drive contradicts how it is
// configured. Gravity gives roll and pitch; the yaw is
// that by which the accelerometer's horizontal accelerations are turned against those of wheel and
// gyro. docs/estimation.md, "A mounting that is found".
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "input/mounting_windows.h"

namespace gprodom {

// Takes that direction to the up axis, by the smallest turn.
Eigen::Matrix3d levelled(const Eigen::Vector3d& up);

class MountingSearch {
 public:
  // configured: the axes are known, except while the drive casts doubt on them.
  explicit MountingSearch(bool configured = false) : configured_(configured) {}

  // As MountingWindows::add(), in axes that are level but for slopes.
  void add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
           const Eigen::Vector3d& gyro_bias);

  // The turn of the body's axes that is found, new from old; nothing until it is known at all, and
  // then until it is known twice as well; nor while the axes are as configured. What is added later
  // must be in the new axes.
  std::optional<Eigen::Matrix3d> take_turn();

  // rad, standard deviation of the yaw in the axes of the last turn that was taken; uniform before.
  double yaw_sigma() const { return taken_sigma_; }
  static constexpr double kUniform = 1.8137993642342178;  // rad, pi / sqrt(3)

  bool known() const { return configured_ ? !doubted_ : taken_sigma_ < kUniform; }
  bool is_configured() const { return configured_; }
  // The drive contradicts the configured axes, beyond doubt.
  bool is_contradicted() const { return configured_ && contradicted_; }

  bool is_certain() const;  // no turn will be found any more

  // The axes are those that have been found earlier.
  void resume(double yaw_sigma);

 private:
  std::vector<double> log_likelihood(const Eigen::Vector2d& product) const;  // of each angle
  void weigh();

  bool configured_;
  MountingWindows windows_;
  // Of differences between accelerations one second apart, wheel w and accelerometer f: f . w and
  // f x w, squares, and how many there are. mirrored: with the sign of f_x reversed.
  Eigen::Vector2d product_ = Eigen::Vector2d::Zero(), mirrored_ = Eigen::Vector2d::Zero();
  double squares_ = 0.0, count_ = 0.0;
  // Sums of the accelerations themselves while the robot moves, of which the mean slope is known.
  Eigen::Vector2d by_wheel_ = Eigen::Vector2d::Zero(), by_imu_ = Eigen::Vector2d::Zero();
  double moving_ = 0.0;
  std::optional<double> earlier_sigma_;  // rad, of the yaw as found earlier
  double earlier_yaw_ = 0.0;             // its, in the present axes
  double yaw_ = 0.0, sigma_ = kUniform;  // rad, of the present axes
  double taken_sigma_ = kUniform;
  // Of the configured axes: they may be wrong; they are; they are turned.
  bool doubted_ = false, contradicted_ = false, turned_ = false;
};

}  // namespace gprodom
