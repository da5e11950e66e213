// White noise for simulated sensors; the same seed gives the same.
#pragma once

#include <Eigen/Core>
#include <random>

namespace gprodom {

class Noise {
 public:
  explicit Noise(unsigned seed) : random_(seed) {}

  double operator()(double sigma = 1.0) { return sigma * normal_(random_); }
  // In this order, whatever the compiler.
  Eigen::Vector3d vector(double sigma) { return {(*this)(sigma), (*this)(sigma), (*this)(sigma)}; }

  // On both of what an IMU measures.
  template <class Imu>
  void shake(Imu& imu, double accel_sigma, double gyro_sigma) {
    for (int axis = 0; axis < 3; ++axis) {
      imu.acceleration[axis] += (*this)(accel_sigma);
      imu.angular_velocity[axis] += (*this)(gyro_sigma);
    }
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace gprodom
