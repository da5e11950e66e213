// The track in `map`: odometry between places along it, tied together where the radar saw ground
// again. In the plane, since gravity holds roll and pitch, with the wheel's scale, which is one
// unknown for the whole track, and with the slip of each step, which is usually none. Solved off
// the fast path. docs/estimation.md, "Pose graph".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "estimation/graph/slip_model.h"
#include "estimation/planar_geometry.h"

namespace gprodom {

struct PoseGraphOptions {
  double revisit_yaw_sigma = 0.2;  // rad; a revisit is driven along the track, roughly
  // Cauchy, standard deviations, while revisits are sorted out.
  double robust_threshold = kRevisitRobustThreshold;
  double drop_beyond = 4.0;  // standard deviations along the track at which a revisit is wrong
  int max_iterations = 30;
  SlipModel slip;
};

// Odometry from one place to the next. The wheel's scale is one error for the whole track: a step
// states what it would be with another scale, and its covariance is what is left besides.
struct PlanarStep {
  PlanarPose measured;                                       // with `scale`
  double scale = 1.0;                                        // reported over true distance
  Eigen::Vector3d d_scale = Eigen::Vector3d::Zero();         // of (x, y, yaw), m, rad
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // of (x, y, yaw), scale known
  double seconds = 0.0;                                      // that it took
  // Standard deviation of the slip (slip_model.h) that no witness has seen; 0: there can be none.
  double slip_sigma = 0.0;
  double believed_slip_sigma = 0.0;  // of the slip that `measured` is without
};

using Matrix5d = Eigen::Matrix<double, 5, 5>;

struct PlanarEstimate {
  PlanarPose pose;
  double scale = 1.0;
  double slip = 0.0;  // of the last step
  // Of x, y, yaw, scale, slip; position in map axes, errors of the pose itself.
  Matrix5d covariance = Matrix5d::Zero();
};

// Two steps, one after the other, as one.
PlanarStep joined(const PlanarStep& first, const PlanarStep& second);

// One step on, without a new solution: the slip goes on as it was.
PlanarEstimate extend(const PlanarEstimate& from, const PlanarStep& step, const SlipModel& model);

struct WhitenedStep {
  PlanarStep odometry;
  Eigen::Matrix3d whitening;
};

struct PoseGraphSolution {
  std::vector<PlanarPose> nodes;  // in map; the first is where it was, unless revisits tie to map
  std::vector<bool> trusted;      // per revisit, in the order they were added
  PlanarEstimate newest;
};

class PoseGraph {
 public:
  PoseGraph(const PlanarPose& first, const PoseGraphOptions& options);

  // A node one step on from the newest. Returns its number, from 1. Throws std::invalid_argument
  // where the covariance is not positive definite.
  std::size_t add_node(const PlanarStep& step);

  // The track as a whole lies elsewhere: it is now known how it lies in map.
  void move(const PlanarPose& in_map_of_before);

  // Throws std::invalid_argument where a node does not exist or a sigma is not positive.
  void add_revisit(const RevisitEdge& edge);

  // Takes nodes out with the revisits that they are the ends of; those left keep their order. The
  // steps to and from a node become one, by which no odometry is lost; but where its yaw is known
  // no better than to some degrees, a step holds the graph together and says nothing any more.
  // Throws std::invalid_argument where the first or the newest node is to go.
  void keep_only(const std::vector<bool>& nodes);

  // Gauss-Newton from the last solution, first with a robust kernel on the revisits, which is as
  // wide at first as the worst of them asks. Those that the solution contradicts are left out and
  // it is solved again; none is out for good, the next solve() asks all of them anew. scale,
  // scale_sigma: what is known of the wheel's scale without revisits (sigma 0: held). Throws
  // std::runtime_error where no solution is found.
  PoseGraphSolution solve(double scale, double scale_sigma);

  // In map, of the last solution; nodes since are dead reckoned from it.
  const std::vector<PlanarPose>& nodes() const { return nodes_; }
  const std::vector<RevisitEdge>& revisits() const { return revisits_; }

  // Of the step from a node to the next, in the last solution; of the newest node, as before it.
  double slip(std::size_t from) const;
  // What it may have been before anything was measured, a standard deviation.
  double slip_sigma(std::size_t from) const;
  // Of a place near a node, in map.
  PlanarPose place(std::size_t node, const PlanarPose& at, const WheelWay& way) const;

 private:
  PoseGraphOptions options_;
  std::vector<PlanarPose> nodes_;
  std::vector<WhitenedStep> steps_;  // steps_[i] leads from node i to node i + 1
  std::vector<double> slips_;        // of the steps, in the last solution
  std::vector<RevisitEdge> revisits_;
  std::optional<double> scale_;  // of the last solution

  PlanarPose place(const std::vector<PlanarPose>& nodes, std::size_t node, const PlanarPose& at,
                   const WheelWay& way) const;
  std::vector<double> deviations(const std::vector<PlanarPose>& nodes) const;
  double widest(const std::vector<double>& deviations) const;
};

}  // namespace gprodom
