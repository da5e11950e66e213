#include "pipeline/map_frame.h"

namespace gprodom {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

// p_map = R p_odom + p. With errors (dp, dθ) in map axes, those of the correction (dp_c, dθ_c):
//   dp_map = R dp_odom + dp_c - [R p_odom]x dθ_c,   dθ_map = R dθ_odom + dθ_c.
OdometryEstimate in_map(const Correction& correction, const OdometryEstimate& estimate) {
  const Eigen::Matrix3d rotation = correction.q_map_odom.toRotationMatrix();
  const Eigen::Vector3d turned = rotation * estimate.p_odom_body;
  OdometryEstimate placed = estimate;
  placed.p_odom_body = turned + correction.p_map_odom;
  placed.q_odom_body = (correction.q_map_odom * estimate.q_odom_body).normalized();

  Matrix6d from_odom = Matrix6d::Zero();
  from_odom.topLeftCorner<3, 3>() = rotation;
  from_odom.bottomRightCorner<3, 3>() = rotation;
  Matrix6d from_correction = Matrix6d::Identity();
  from_correction.topRightCorner<3, 3>() = -skew(turned);
  const Matrix6d covariance = from_odom * estimate.pose_covariance * from_odom.transpose() +
                              from_correction * correction.covariance * from_correction.transpose();
  placed.pose_covariance = 0.5 * (covariance + covariance.transpose());
  return placed;
}

std::vector<OdometryEstimate> MapFrame::place(const Outputs& outputs) {
  waiting_.insert(waiting_.end(), outputs.corrections.begin(), outputs.corrections.end());
  std::vector<OdometryEstimate> placed;
  placed.reserve(outputs.odometry.size());
  for (const auto& estimate : outputs.odometry) {
    while (!waiting_.empty() && waiting_.front().time <= estimate.time) {
      in_force_ = waiting_.front();
      waiting_.pop_front();
    }
    placed.push_back(in_map(in_force_, estimate));
  }
  return placed;
}

void MapFrame::reset() {
  in_force_ = Correction();
  waiting_.clear();
}

}  // namespace gprodom
