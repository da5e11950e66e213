#include "map/map_frame.h"

#include <Eigen/Eigenvalues>

namespace gprodom {
namespace {

using Eigen::Matrix3d;

// p_map = R p_odom + p.
OdometryEstimate in_map(const Correction& correction, const OdometryEstimate& estimate) {
  OdometryEstimate placed = estimate;
  placed.p_odom_body = correction.q_map_odom * estimate.p_odom_body + correction.p_map_odom;
  placed.q_odom_body = (correction.q_map_odom * estimate.q_odom_body).normalized();
  return placed;
}

Matrix3d positive(const Matrix3d& symmetric) {
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(0.5 * (symmetric + symmetric.transpose()));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

OdometryEstimate planar_estimate(const PathState& state) {
  OdometryEstimate estimate;
  estimate.p_odom_body << state.pose.p, 0.0;
  set_planar_block(state.pose_covariance, estimate.pose_covariance);
  return estimate;
}

Matrix3d carried_covariance(const Correction& correction, const Matrix3d& covariance,
                            const OdometryEstimate& since, const OdometryEstimate& here) {
  const Eigen::Vector3d way = here.p_odom_body - since.p_odom_body;
  const Matrix3d in_odom = lever(way.head<2>());
  const Matrix3d added =
      positive(planar_block(here.pose_covariance) -
               in_odom * planar_block(since.pose_covariance) * in_odom.transpose());
  const Matrix3d turn = correction.q_map_odom.toRotationMatrix();  // about z: x and y alone
  const Eigen::Vector3d way_in_map =
      correction.q_map_odom * here.p_odom_body - correction.q_map_odom * since.p_odom_body;
  const Matrix3d moved = lever(way_in_map.head<2>());
  return moved * covariance * moved.transpose() + turn * added * turn.transpose();
}

std::vector<OdometryEstimate> MapFrame::place(const Outputs& outputs) {
  waiting_.insert(waiting_.end(), outputs.corrections.begin(), outputs.corrections.end());
  std::vector<OdometryEstimate> placed;
  placed.reserve(outputs.odometry.size());
  for (const auto& estimate : outputs.odometry) {
    while (!waiting_.empty() && waiting_.front().time <= estimate.time) {
      in_force_ = waiting_.front();
      waiting_.pop_front();
      since_ = estimate;
      corrected_ = true;
    }
    placed.push_back(in_map(in_force_, estimate));
    if (!corrected_) continue;
    set_planar_block(
        carried_covariance(in_force_, planar_block(in_force_.covariance), since_, estimate),
        placed.back().pose_covariance);
    newest_covariance_ = placed.back().pose_covariance;
  }
  return placed;
}

void MapFrame::reset(const std::optional<Correction>& correction) {
  *this = MapFrame();
  if (correction) waiting_.push_back(*correction);
}

std::optional<Correction> MapFrame::now() const {
  if (!corrected_) return std::nullopt;
  Correction correction = in_force_;
  correction.covariance = newest_covariance_;
  return correction;
}

}  // namespace gprodom
