#include "pipeline/mounting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pipeline/pipeline.h"

namespace gprodom {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
// Before the start, gravity further than this off the up axis is a mounting and no slope.
constexpr double kNoSlope = 30 * kDegree;
// m/s^2/sqrt(Hz), at least, while the yaw of the mounting is not known; an acceleration and its
// error last about a second.
constexpr double kUntrusted = 0.3;

// rad; an IMU away from the wheels, a wheel that is late, and a lean of the IMU turn accelerations
// by so much, which no scatter shows.
constexpr double kUnseen = 4 * kDegree;
// Share of its standard deviation to which the yaw must have become better to be used anew.
constexpr double kBetter = 0.7;

double heading(const Eigen::Quaterniond& q_odom_body) {
  const Vector3d ahead = q_odom_body * Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

}  // namespace

Matrix3d rotation_of(const Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) *
          Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Vector3d rpy_of(const Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

Vector3d mounting_at_first(const Config& config, const std::optional<FoundMounting>& found) {
  if (config.imu.rpy_body_imu) return *config.imu.rpy_body_imu;
  return found ? found->rpy_body_imu : Vector3d::Zero();
}

Config without_accelerations(Config config) {
  config.wheel.slip_threshold = 0.0;
  config.wheel.slip_share = 0.0;
  return config;
}

StateResult in_other_axes(StateResult result, const Matrix3d& R) {
  NavState& x = result.state;
  const NavState before = x;
  const Eigen::Quaterniond tilted = before.q_odom_body * Eigen::Quaterniond(R).conjugate();
  const double turn = heading(before.q_odom_body) - heading(tilted);
  const Eigen::Quaterniond about_up(Eigen::AngleAxisd(turn, Vector3d::UnitZ()));
  x.q_odom_body = (about_up * tilted).normalized();
  x.v_odom = x.q_odom_body * (before.q_odom_body.conjugate() * before.v_odom);
  x.gyro_bias = R * before.gyro_bias;
  x.accel_bias = R * before.accel_bias;
  // An error of the tilt turns with the IMU; those of place and velocity stay.
  const Matrix3d turned = about_up.toRotationMatrix();
  StateMatrix J = StateMatrix::Identity();
  J.block<3, 3>(row::kTheta, row::kTheta) = turned;
  J.block<3, 3>(row::kP, row::kTheta) = so3::skew(x.p_odom) * turned - so3::skew(before.p_odom);
  J.block<3, 3>(row::kV, row::kTheta) = so3::skew(x.v_odom) * turned - so3::skew(before.v_odom);
  J.block<3, 3>(row::kBg, row::kBg) = R;
  J.block<3, 3>(row::kBa, row::kBa) = R;
  const StateMatrix moved = J * result.covariance * J.transpose();
  result.covariance = 0.5 * (moved + moved.transpose());
  return result;
}

// Before the start: an IMU that lies on its side, or upside down.
void Pipeline::level_imu() {
  Vector3d force = Vector3d::Zero();
  const TimeNs from = imu_now_ - from_seconds(config_.initializer.duration);
  for (const ImuSample& sample : motion_.imu().between(from, imu_now_))
    force += sample.acceleration;
  if (std::atan2(force.head<2>().norm(), force.z()) < kNoSlope) return;
  const Matrix3d R =
      Eigen::Quaterniond::FromTwoVectors(force, Vector3d::UnitZ()).toRotationMatrix();
  motion_.turn_imu(R);
  R_body_imu_ = R * R_body_imu_;
}

// While the mounting is not known, an acceleration may have any direction.
double Pipeline::turned_error() const {
  return mounting_known_ ? turned_acceleration_ : std::max(kUntrusted, turned_acceleration_);
}

ImuNoise Pipeline::trusted(ImuNoise noise) const {
  noise.accel_density = std::hypot(noise.accel_density, turned_error());
  return noise;
}

void Pipeline::watch_mounting(const StateInput& input) {
  const NavState& x = prediction_.base().state;
  mounting_.add(input.steps, motion_.wheel().distance(input.time), x.gyro_bias);
  if (mounting_known_)
    health_.set("IMU mounting", HealthLevel::kDegraded, mounting_.trouble());
  else
    health_.await("IMU mounting", HealthLevel::kDegraded,
                  "not known yet (imu.rpy_body_imu: auto): drive with changes of speed and bends");
  if (config_.imu.rpy_body_imu) return;
  Vector3d force = Vector3d::Zero();
  double seconds = 0.0;
  for (const MotionStep& step : input.steps) {
    force += step.acceleration * step.dt;
    seconds += step.dt;
  }
  const Vector3d up = x.q_odom_body.conjugate() * Vector3d::UnitZ();
  const Vector3d horizontal = force - up.dot(force) * up;
  // Two equal vectors, one of which is turned by any angle, differ by so much in the mean.
  const double turned =
      found_mounting_ ? std::max(kUnseen, found_mounting_->yaw_sigma) : std::sqrt(2.0);
  turned_acceleration_ = seconds > 0 ? turned * horizontal.norm() / seconds : 0.0;
}

// With auto: what the drive has shown of the mounting takes effect, better and better, also where
// it contradicts what was found earlier. No solve must be under way, so the newest state is the one
// to go on from.
void Pipeline::use_mounting() {
  if (config_.imu.rpy_body_imu) return;
  const StateResult& newest = prediction_.base();
  if (solver_.waiting() > 0 || newest.state.time != motion_.judged_to() || !newest.solve.usable)
    return;
  const auto turn = mounting_.turn();
  if (!turn || !turn->usable) return;
  const bool anew = !mounting_known_ || !mounting_.trouble().empty();
  // At a standstill, since the window's states and what was seen of slip are given up.
  const bool better =
      newest.standing && found_mounting_ && turn->yaw_sigma < kBetter * found_mounting_->yaw_sigma;
  if (!anew && !better) return;
  const StateResult base = in_other_axes(newest, turn->R);
  R_body_imu_ = turn->R * R_body_imu_;
  motion_.turn_imu(turn->R);
  mounting_.turned(turn->R);
  motion_.go_on_from(base);
  if (anew) motion_.trust_accelerations(config_);
  mounting_known_ = true;
  found_mounting_ = {rpy_of(R_body_imu_), turn->yaw_sigma};
  estimator_ = std::make_unique<StateEstimator>(
      config_, InitialState{base.state, gaussian_prior(base.state, base.covariance),
                            motion_.noise_at_standstill()});
  if (record_) estimator_->record();
  prediction_.rebase(base, trusted(motion_.noise(base.state.time, imu_now_)),
                     motion_.wheel_contact(), motion_.imu());
  const Vector3d& rpy = found_mounting_->rpy_body_imu;
  health_.value("imu.roll_deg", rpy.x() / kDegree);
  health_.value("imu.pitch_deg", rpy.y() / kDegree);
  health_.value("imu.yaw_deg", rpy.z() / kDegree);
  health_.value("imu.yaw_sigma_deg", turn->yaw_sigma / kDegree);
  if (!anew) return;
  char said[160];
  std::snprintf(said, sizeof said,
                "IMU mounting found: imu.rpy_body_imu [%.3f, %.3f, %.3f], yaw +- %.3f rad; used "
                "from now on, and improved",
                rpy.x(), rpy.y(), rpy.z(), turn->yaw_sigma);
  out_.warnings.emplace_back(said);
}

}  // namespace gprodom
