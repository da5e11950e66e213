#include "estimation/initializer.h"

#include <cmath>
#include <cstdio>

namespace gprodom {

using Eigen::Vector3d;

namespace {

struct Moments {
  Vector3d mean = Vector3d::Zero();
  double deviation = 0.0;  // RMS over the three axes
};

Moments moments(const std::vector<ImuSample>& samples, Vector3d ImuSample::*field) {
  Moments m;
  for (const auto& s : samples) m.mean += s.*field;
  m.mean /= static_cast<double>(samples.size());
  for (const auto& s : samples) m.deviation += (s.*field - m.mean).squaredNorm();
  m.deviation = std::sqrt(m.deviation / (3.0 * static_cast<double>(samples.size() - 1)));
  return m;
}

std::string refuse(const char* format, double value, double limit) {
  char text[240];
  std::snprintf(text, sizeof text, format, value, limit);
  return text;
}

std::string reason_against(const Config& config, const Moments& gyro, const Moments& accel,
                           double wheel_moved_m) {
  const InitializerConfig& c = config.initializer;
  if (std::abs(wheel_moved_m) > 2 * config.wheel.noise_floor + 1e-3)
    return refuse("the wheel turned %.3f m (limit %.3f): hold the robot still to start",
                  std::abs(wheel_moved_m), 2 * config.wheel.noise_floor + 1e-3);
  if (gyro.deviation > c.max_gyro_std)
    return refuse("gyro deviation %.4f rad/s (initializer.max_gyro_std %.4f): hold the robot still",
                  gyro.deviation, c.max_gyro_std);
  if (accel.deviation > c.max_accel_std)
    return refuse(
        "accelerometer deviation %.3f m/s^2 (initializer.max_accel_std %.3f): hold the "
        "robot still",
        accel.deviation, c.max_accel_std);
  if (gyro.mean.norm() > c.max_gyro_mean)
    return refuse(
        "mean rate %.4f rad/s (initializer.max_gyro_mean %.4f): turning, or a gyro out "
        "of calibration",
        gyro.mean.norm(), c.max_gyro_mean);
  if (std::abs(accel.mean.norm() - c.gravity) > 0.05 * c.gravity)
    return refuse("specific force %.3f m/s^2 is not gravity (%.3f): check the IMU's units",
                  accel.mean.norm(), c.gravity);
  return {};
}

// Rows in the chart at the first state x, sigma apart: see docs/estimation.md, "Start".
MarginalPrior first_prior(const Config& config, const NavState& x, const ImuNoise& noise,
                          double duration) {
  const InitializerConfig& c = config.initializer;
  const double gyro_sigma = noise.gyro_density / std::sqrt(duration);
  const double accel_sigma = noise.accel_density / std::sqrt(duration);
  const double scale_sigma = std::max(config.wheel.scale_sigma, 1e-7);
  MarginalPrior prior;
  prior.x0 = {x};
  prior.A = Eigen::MatrixXd::Zero(17, kStateDim);
  prior.b = Eigen::VectorXd::Zero(17);
  prior.A(0, row::kTheta + 2) = 1 / c.yaw_sigma;
  prior.A.block<3, 3>(1, row::kP).diagonal().setConstant(1 / c.position_sigma);
  prior.A.block<3, 3>(4, row::kV).diagonal().setConstant(1 / config.standstill.velocity_sigma);
  prior.A.block<3, 3>(7, row::kBg).diagonal().setConstant(1 / gyro_sigma);
  // The accelerometer's bias, zero-mean: x holds the part of it that gravity's size shows.
  prior.A.block<3, 3>(10, row::kBa).diagonal().setConstant(1 / config.imu.accel_bias_sigma);
  prior.b.segment<3>(10) = x.accel_bias / config.imu.accel_bias_sigma;
  // Mean specific force = R^T up + bias: tilt and bias are known well together, not apart.
  const Eigen::Matrix3d RT = x.R_odom_body().transpose();
  const Vector3d up(0, 0, c.gravity);
  Eigen::Matrix<double, 3, kStateDim> force = Eigen::Matrix<double, 3, kStateDim>::Zero();
  force.block<3, 3>(0, row::kTheta) = RT * so3::skew(up);
  force.block<3, 3>(0, row::kBa).setIdentity();
  prior.A.block<3, kStateDim>(13, 0) = force / accel_sigma;
  prior.A(16, row::kScale) = 1 / scale_sigma;
  return prior;
}

}  // namespace

Initialization initialize(const Config& config, const std::vector<ImuSample>& samples,
                          double wheel_moved_m) {
  const InitializerConfig& c = config.initializer;
  if (samples.size() < 10)
    return {std::nullopt, refuse("%.0f IMU samples in %.1f s: waiting for IMU data",
                                 static_cast<double>(samples.size()), c.duration)};
  const double duration = to_seconds(samples.back().time - samples.front().time);
  if (duration < 0.9 * c.duration)
    return {std::nullopt,
            refuse("%.2f s of standstill seen (initializer.duration %.2f)", duration, c.duration)};
  const Moments gyro = moments(samples, &ImuSample::angular_velocity);
  const Moments accel = moments(samples, &ImuSample::acceleration);
  if (std::string why = reason_against(config, gyro, accel, wheel_moved_m); !why.empty())
    return {std::nullopt, why};

  InitialState initial;
  const double root_dt = std::sqrt(duration / static_cast<double>(samples.size() - 1));
  initial.noise.gyro_density = std::max(config.imu.gyro_noise_density, gyro.deviation * root_dt);
  initial.noise.accel_density = std::max(config.imu.accel_noise_density, accel.deviation * root_dt);

  NavState& x = initial.state;
  x.time = samples.back().time;
  const Vector3d up_body = accel.mean.normalized();
  const double roll = std::atan2(up_body.y(), up_body.z());
  const double pitch = std::atan2(-up_body.x(), std::hypot(up_body.y(), up_body.z()));
  x.q_odom_body =
      Eigen::AngleAxisd(pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Vector3d::UnitX());
  x.gyro_bias = gyro.mean;
  x.accel_bias = accel.mean - up_body * c.gravity;
  x.wheel_scale = config.wheel.scale;
  initial.prior = first_prior(config, x, initial.noise, duration);
  return {initial, {}};
}

}  // namespace gprodom
