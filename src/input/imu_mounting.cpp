#include "input/imu_mounting.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

namespace {

// s. A shorter filter makes noise of the gyro into accelerations, a longer one is late
// (docs/estimation.md has what each did).
constexpr double kFilter_s = 0.02;
constexpr double kLongestStep_s = 0.12;  // beyond, samples are missing and the filter begins anew

Eigen::Matrix3d rotation(const Eigen::Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace

ImuMounting::ImuMounting(const ImuConfig& config)
    : R_body_imu_(rotation(config.rpy_body_imu.rpy.value_or(Eigen::Vector3d::Zero()))),
      arm_(config.lever_arm),
      takes_arm_out_(config.rpy_body_imu.rpy && !arm_.isZero(0.0)) {}

void ImuMounting::turn(const Eigen::Matrix3d& R_new_old) {
  level(R_new_old);
  takes_arm_out_ = !arm_.isZero(0.0);
  last_.reset();
}

Eigen::Vector3d ImuMounting::rpy() const {
  const Eigen::Matrix3d& R = R_body_imu_;
  return {std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

ImuSample ImuMounting::in_body(const ImuSample& in_imu) {
  ImuSample result = in_imu;
  result.acceleration = R_body_imu_ * in_imu.acceleration / accel_scale_;
  result.angular_velocity = R_body_imu_ * in_imu.angular_velocity;
  if (takes_arm_out_) result.acceleration -= added_by_arm(result);
  return result;
}

// The filter d(rate)/dt = (omega - rate) / T gives the angular acceleration as well. With omega and
// rate in the second product, what is taken out is the derivative of R (rate x r): it adds up.
Eigen::Vector3d ImuMounting::added_by_arm(const ImuSample& at) {
  const double dt = last_ ? to_seconds(at.time - last_->time) : kLongestStep_s;
  if (dt >= kLongestStep_s) {
    rate_ = at.angular_velocity;
    angular_.setZero();
  } else if (dt > 0) {
    const Eigen::Vector3d change = -std::expm1(-dt / kFilter_s) * (at.angular_velocity - rate_);
    rate_ += change;
    angular_ = change / dt;
  }
  if (dt > 0) last_ = at;
  return angular_.cross(arm_) + at.angular_velocity.cross(rate_.cross(arm_));
}

}  // namespace gprodom
