// What IMU and wheel measured over one second, for the judge of gradual slip.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "estimation/state_input.h"

namespace gprodom::slip {

// Level, along the body's x.
Eigen::Vector3d heading(const Eigen::Quaterniond& q_world_body);

// Motion over steps from an attitude, without gravity, in the axes of the world.
struct LevelMotion {
  LevelMotion(const std::vector<MotionStep>& steps, const Eigen::Quaterniond& q_world_body,
              const Eigen::Vector3d& gyro_bias);

  // A change of velocity or a distance: along the way, and to the left of it.
  Eigen::Vector2d level(const Eigen::Vector3d& v_world) const {
    return {forwards.dot(v_world), leftwards.dot(v_world)};
  }
  Eigen::Vector2d mean_acceleration() const { return level(dv) / dt; }

  double dt = 0.0;                                   // s
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();      // m/s
  Eigen::Vector3d dp = Eigen::Vector3d::Zero();      // m, from rest
  Eigen::Vector3d turned = Eigen::Vector3d::Zero();  // rad, body
  Eigen::Quaterniond q;                              // at the end
  // Level, between the headings at both ends: there the change of speed is the one along the way.
  Eigen::Vector3d forwards, leftwards;
};

// Sums over one second. Measurements are compared over that time: noise from sample to sample is
// not known as well as that of seconds, and would look like slip.
struct Block {
  void add(const StateInput& input, const LevelMotion& motion, double wheel_scale);
  // Change of speed along the accelerometer's axes (m/s) by the leak of gravity (row::kTilt, rad).
  Eigen::Matrix2d by_tilt() const;

  double dt = 0, wheel_m = 0, turned = 0;
  int intervals = 0;
  // Along and to the left of the accelerometer's axes: change of speed (m/s); by how much the way
  // is less than that at the last speed (m); change of speed times the turn before it (m/s).
  Eigen::Vector2d gained = Eigen::Vector2d::Zero(), behind_m = Eigen::Vector2d::Zero(),
                  turned_before = Eigen::Vector2d::Zero();
  double turn_s = 0;  // rad s; integral of the turn since the block's beginning
  Eigen::Vector2d forwards = Eigen::Vector2d::Zero(), leftwards = Eigen::Vector2d::Zero();  // s
  Eigen::Vector3d rates = Eigen::Vector3d::Zero();  // rad, body
  double wheel_variance = 0;                        // m^2
  ImuNoise noise;
  double speed_variance = 0, tilt_variance = 0;  // m^2/s^2, rad^2: by the IMU's noise
  bool standing = false, wheel = true;
  bool gap = false;  // of the IMU
};

}  // namespace gprodom::slip
