// Poses in the plane, and what ties two of them together where the radar saw ground again. Used by
// the factors between states and by the pose graph.
#pragma once

#include <Eigen/Core>
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
PlanarPose between(const PlanarPose& a, const PlanarPose& b);
PlanarPose compose(const PlanarPose& a, const PlanarPose& b_in_a);

// What of the way from a node to a place near it the wheel has measured: a slip l makes it e^l
// times as long.
struct WheelWay {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  // m, in the node's frame
  bool to_node = false;  // on the step that leads to the node, not on the one from it

  // Of the track's steps, the one that it lies on. Step i leads from node i to the next.
  std::size_t step(std::size_t node) const { return to_node ? node - 1 : node; }
};

// A place near a node, told without slip, where there is slip on its way.
inline PlanarPose stretched(const PlanarPose& at, const WheelWay& way, double slip) {
  return {at.p + std::expm1(slip) * way.p, at.yaw};
}

// As RevisitEdge::memory: a place that is fixed in map, on ground remembered from before.
constexpr std::size_t kInMap = std::numeric_limits<std::size_t>::max();

// Cauchy threshold of a revisit's distance along the track, standard deviations.
constexpr double kRevisitRobustThreshold = 1.5;

// The antenna in query lies `offset_m` forwards of the one in memory, along the direction that the
// robot faced there, and `lateral_m` to its left; mirrored: it faced the other way. Both are places
// near a node, given in its frame, or of memory in map.
struct RevisitEdge {
  std::size_t memory = 0, query = 0;
  PlanarPose memory_at = {}, query_at = {};
  double offset_m = 0.0, sigma_m = 0.01;
  double lateral_m = 0.0, lateral_sigma_m = 0.15;
  bool mirrored = false;
  WheelWay memory_way = {}, query_way = {};  // of memory_at, query_at; none of places fixed in map
};

}  // namespace gprodom
