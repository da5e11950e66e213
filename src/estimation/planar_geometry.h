// Poses in the plane, and the revisit (loop closure) between two of them. Used by the factors
// between states and by the pose graph.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gprodom {

// An angle in (-pi, pi].
inline double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

struct PlanarPose {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  // m
  double yaw = 0.0;                             // rad
};

// The pose of `b` in the frame of `a`, and a pose given in the frame of `a`.
inline PlanarPose between(const PlanarPose& a, const PlanarPose& b) {
  return {Eigen::Rotation2Dd(-a.yaw) * (b.p - a.p), wrapped(b.yaw - a.yaw)};
}
inline PlanarPose compose(const PlanarPose& a, const PlanarPose& b_in_a) {
  return {a.p + Eigen::Rotation2Dd(a.yaw) * b_in_a.p, wrapped(a.yaw + b_in_a.yaw)};
}

// Jacobian of (x, y, yaw) at another place of what is rigid; `way` leads there, in the axes of
// both.
inline Eigen::Matrix3d lever(const Eigen::Vector2d& way) {
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J(0, 2) = -way.y();
  J(1, 2) = way.x();
  return J;
}

// The block of x, y and yaw, which is the last, of a covariance with more rows. Setting it removes
// its correlation with the rest (height, roll and pitch), which keeps its own.
template <int N>
Eigen::Matrix3d planar_block(const Eigen::Matrix<double, N, N>& covariance) {
  constexpr std::array kPlanar{0, 1, N - 1};
  return covariance(kPlanar, kPlanar);
}
template <int N>
void set_planar_block(const Eigen::Matrix3d& block, Eigen::Matrix<double, N, N>& covariance) {
  constexpr std::array kPlanar{0, 1, N - 1};
  covariance(kPlanar, Eigen::all).setZero();
  covariance(Eigen::all, kPlanar).setZero();
  covariance(kPlanar, kPlanar) = block;
}

// The part of the displacement from a node to a place near it that the wheel has measured. A slip l
// makes it e^l times as long.
struct WheelWay {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  // m, in the node's frame
  bool to_node = false;  // it lies on the step to the node; otherwise on the step from the node

  // The number of the step on which it lies. Step i leads from node i to the next.
  std::size_t step(std::size_t node) const { return to_node ? node - 1 : node; }
};

// The place near a node, given for no slip, after a slip of its step.
inline PlanarPose stretched(const PlanarPose& at, const WheelWay& way, double slip) {
  return {at.p + std::expm1(slip) * way.p, at.yaw};
}

// Value of RevisitEdge::memory for a place fixed in map, on the ground of an earlier track.
constexpr std::size_t kInMap = std::numeric_limits<std::size_t>::max();

// Cauchy threshold of a revisit's distance along the track, standard deviations.
constexpr double kRevisitRobustThreshold = 1.5;

// The antenna at the query lies `offset_m` ahead of the antenna at the memory, along the robot's
// heading there, and `lateral_m` to its left. mirrored: the headings are opposite. Both places are
// given in the frame of a nearby node; that of the memory may be given in map.
struct RevisitEdge {
  std::size_t memory = 0, query = 0;
  PlanarPose memory_at = {}, query_at = {};
  double offset_m = 0.0, sigma_m = 0.01;
  double lateral_m = 0.0, lateral_sigma_m = 0.15;
  bool mirrored = false;
  WheelWay memory_way = {}, query_way = {};  // of memory_at, query_at; empty for places in map
};

}  // namespace gprodom
