// Takes samples of the IMU from its own axes and place to the body's axes and origin: what an IMU
// there would have measured (imu.rpy_body_imu, imu.lever_arm), once the accelerometer's scale is
// known, without that.
#pragma once

#include <optional>

#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

class ImuMounting {
 public:
  explicit ImuMounting(const ImuConfig& config);

  // In the order in which samples come; a late one is turned by what is known by then.
  ImuSample in_body(const ImuSample& in_imu);

  // From now on in other axes, new from old. The yaw of R_body_imu is known then.
  void turn(const Eigen::Matrix3d& R_new_old);
  // Likewise, where gravity alone has shown roll and pitch.
  void level(const Eigen::Matrix3d& R_new_old) { R_body_imu_ = R_new_old * R_body_imu_; }
  const Eigen::Matrix3d& R_body_imu() const { return R_body_imu_; }
  Eigen::Vector3d rpy() const;  // rad; roll, pitch, yaw of that

  // From now on forces are divided by this as well.
  void divide_forces(double accel_scale) { accel_scale_ *= accel_scale; }
  double accel_scale() const { return accel_scale_; }  // all of it

 private:
  // a_imu = a_body + alpha x r + omega x (omega x r), r the IMU's place; m/s^2, body axes.
  Eigen::Vector3d added_by_arm(const ImuSample& at);

  Eigen::Matrix3d R_body_imu_;
  const Eigen::Vector3d arm_;  // m, body
  bool takes_arm_out_;         // not before the yaw is known
  double accel_scale_ = 1.0;   // measured over true
  // Turn rate through a low-pass filter of first order, and the sample that it last took.
  std::optional<ImuSample> last_;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero(), angular_ = Eigen::Vector3d::Zero();
};

}  // namespace gprodom
