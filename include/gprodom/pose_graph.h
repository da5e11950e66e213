// The track in `map`: odometry between places along it, tied together where the radar saw ground
// again. In the plane, since gravity holds roll and pitch, and with the wheel's scale, which is one
// error for the whole track and not one for each piece. Solved off the fast path.
// docs/estimation.md, "Pose graph".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace gprodom {

struct PlanarPose {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  // m
  double yaw = 0.0;                             // rad
};

// The pose of `b` in the frame of `a`, and a pose given in the frame of `a`.
PlanarPose between(const PlanarPose& a, const PlanarPose& b);
PlanarPose compose(const PlanarPose& a, const PlanarPose& b_in_a);

struct PoseGraphOptions {
  double scale_sigma = 0.02;       // prior of the scale error that all of the odometry shares
  double revisit_yaw_sigma = 0.2;  // rad; a revisit is driven along the track, roughly
  double robust_threshold = 1.5;   // Cauchy, standard deviations, while revisits are sorted out
  double drop_beyond = 4.0;  // standard deviations along the track at which a revisit is wrong
  int max_iterations = 30;
};

// Node `query` lies `offset_m` forwards of node `memory` along the memory's direction and
// `lateral_m` to its left; mirrored: it faces the other way.
struct RevisitEdge {
  std::size_t memory = 0, query = 0;
  double offset_m = 0.0, sigma_m = 0.01;
  double lateral_m = 0.0, lateral_sigma_m = 0.15;
  bool mirrored = false;
};

struct PoseGraphSolution {
  std::vector<PlanarPose> nodes;  // in map; the first is where it was
  std::vector<bool> trusted;      // per revisit, in the order they were added
  double scale_error = 0.0;       // odometry over true distance, less one
  Eigen::Matrix3d newest_covariance =
      Eigen::Matrix3d::Zero();  // of the newest node: x, y, yaw, in map axes
};

class PoseGraph {
 public:
  PoseGraph(const PlanarPose& first, const PoseGraphOptions& options);

  // A node `step` on from the newest, by odometry; `covariance` of (x, y, yaw) of the step in the
  // frame of the node before, without the error of the scale. Returns its number, from 1.
  std::size_t add_node(const PlanarPose& step, const Eigen::Matrix3d& covariance);

  // Throws std::invalid_argument where a node does not exist or a sigma is not positive.
  void add_revisit(const RevisitEdge& edge);

  // Gauss-Newton, first with a robust kernel on the revisits. Those that the solution contradicts
  // are left out and it is solved again; none is out for good, the next solve() asks all of them
  // anew. Throws std::runtime_error where no solution is found.
  PoseGraphSolution solve() const;

  std::size_t nodes() const { return initial_.size(); }
  std::size_t revisits() const { return revisits_.size(); }

 private:
  struct Step {
    PlanarPose measured;
    Eigen::Matrix3d whitening;
  };
  PoseGraphOptions options_;
  std::vector<PlanarPose> initial_;  // dead reckoning
  std::vector<Step> steps_;          // steps_[i] leads from node i to node i + 1
  std::vector<RevisitEdge> revisits_;

  std::vector<double> deviations(const std::vector<PlanarPose>& nodes) const;
};

}  // namespace gprodom
