// Pose graph of the track in `map`: odometry steps between nodes along it, and revisits (loop
// closures). It is planar, since gravity determines roll and pitch. The wheel's scale is one
// unknown for the whole track. Each step has a slip, which is usually zero. Solved off the fast
// path. docs/estimation.md, "Pose graph".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "estimation/graph/slip_model.h"
#include "estimation/planar_geometry.h"

namespace gprodom {

struct PoseGraphOptions {
  double revisit_yaw_sigma = 0.2;  // rad; a pass is only roughly parallel to the earlier one
  // Cauchy, standard deviations; used while wrong revisits are being removed.
  double robust_threshold = kRevisitRobustThreshold;
  // Norm of a revisit's residual (along, lateral, yaw), standard deviations; beyond, it is wrong.
  // As rare for three as four standard deviations are for one: 6e-5.
  double drop_beyond = 4.7;
  // Huber, of the same norm; in the last solution. 95 % of right revisits are below.
  double full_weight_below = 2.8;
  int max_iterations = 30;
  SlipModel slip;
};

// Odometry from one node to the next. The error of the wheel's scale is common to all steps, so a
// step has a derivative by the scale, and its covariance is without that error.
struct PlanarStep {
  PlanarPose measured;                                       // with `scale`
  double scale = 1.0;                                        // reported over true distance
  Eigen::Vector3d d_scale = Eigen::Vector3d::Zero();         // of (x, y, yaw), m, rad
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // of (x, y, yaw), scale known
  double seconds = 0.0;                                      // duration
  // Prior standard deviation of slip (slip_model.h) that was not detected; 0: no slip is possible.
  double slip_sigma = 0.0;
  double believed_slip_sigma = 0.0;  // of the estimated slip that `measured` is already free of
  bool cut = false;                  // it says nothing, and the solution is without it
};

// A position from outside: the antenna was at `p` in map. Its error is partly white, and partly a
// Gauss-Markov process that goes on from that of another fix before it.
struct FixEdge {
  std::size_t node = 0;
  PlanarPose at;  // in the node's frame: place of the antenna, heading of the robot
  WheelWay way;   // of `at`
  Eigen::Vector2d p = Eigen::Vector2d::Zero();               // m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  // m^2, map axes; of both parts
  double white = 1.0;                                        // share of the variance
  std::optional<std::size_t> before;  // number of the fix that its lasting error goes on from
  double kept = 0.0;                  // correlation of the two lasting errors
  double yaw = 0.0, yaw_sigma = 0.0;  // rad; sigma 0: no heading
};

using Matrix5d = Eigen::Matrix<double, 5, 5>;

struct PlanarEstimate {
  PlanarPose pose;
  double scale = 1.0;
  double slip = 0.0;  // of the last step
  // Of x, y, yaw, scale, slip. Position in map axes.
  Matrix5d covariance = Matrix5d::Zero();
};

// Combines two consecutive steps into one.
PlanarStep joined(const PlanarStep& first, const PlanarStep& second);

// Predicts the estimate over one step, without a new solution; the slip stays the same.
PlanarEstimate extend(const PlanarEstimate& from, const PlanarStep& step, const SlipModel& model);

struct WhitenedStep {
  PlanarStep odometry;
  Eigen::Matrix3d whitening;
};

// What is known of the first node in map, without revisits.
struct FirstPrior {
  PlanarPose pose;
  Eigen::Matrix3d whitening;
};

struct PoseGraphSolution {
  std::vector<PlanarPose> nodes;  // in map
  std::vector<bool> trusted;      // for each revisit, in the order in which they were added
  PlanarEstimate newest;
  double work = 0.0;   // NormalMatrix::work()
  int iterations = 0;  // of Gauss-Newton; each factorises the normal equations once
};

class PoseGraph {
 public:
  // The first node defines the map's frame: it is held. With a prior, or a trusted revisit whose
  // older end is fixed in map, it is free.
  PoseGraph(const PlanarPose& first, const PoseGraphOptions& options);

  // The first node is where it is now, with this covariance of (x, y, yaw) in map axes. Throws
  // std::invalid_argument if it is not positive definite.
  void set_first_prior(const Eigen::Matrix3d& covariance);

  // Adds a node one step after the newest. Returns its number, from 1. Throws std::invalid_argument
  // if the covariance is not positive definite.
  std::size_t add_node(const PlanarStep& step);

  // Moves the whole track, when its pose in the map of an earlier track becomes known. A prior of
  // the first node was of another frame, and ends.
  void move(const PlanarPose& in_map_of_before);

  // Throws std::invalid_argument if a node does not exist or a sigma is not positive.
  void add_revisit(const RevisitEdge& edge);

  // Replaces all fixes. They tie the graph to their frame once its first node has a prior. Throws
  // std::invalid_argument if a node or an earlier fix does not exist, or a covariance is not
  // positive definite.
  void set_fixes(std::vector<FixEdge> fixes);

  // Removes all fixes, and nodes together with their revisits; the other nodes keep their order.
  // The steps to and from a removed node are combined into one, so no odometry is lost. If the yaw
  // of a combined step is uncertain by some degrees, the step only keeps the graph connected and
  // has no information. cut: for each node, whether the step into it is cut. Revisits should then
  // tie what lies between two cuts to the rest. Throws std::invalid_argument if the first or the
  // newest node is to be removed.
  void keep_only(const std::vector<bool>& nodes, const std::vector<bool>& cut = {});

  // Gauss-Newton from the last solution. Where that contradicts a trusted or a new revisit, first
  // with a redescending kernel on the revisits, which begins wide enough for the worst of them.
  // Revisits that contradict the solution are left out, and it is solved again; in the end with a
  // kernel that weighs most of them in full. What was left out stays out as long as it contradicts,
  // but is tried again where the others contradict each other without it. scale, scale_sigma: prior
  // of the wheel's scale, without revisits (sigma 0: fixed). Throws std::runtime_error if no
  // solution is found.
  PoseGraphSolution solve(double scale, double scale_sigma);

  // Between two solutions: the nodes after `from` alone, where the others and the scale stay as
  // they are. known: covariance of (x, y, yaw) of `from`, map axes. Nothing without a revisit of
  // these nodes, or with fixes. Throws std::runtime_error if no solution is found, and
  // std::invalid_argument if `known` is not positive definite.
  struct NewestSolution {
    PlanarPose newest;
    double slip = 0.0;                 // of the last step
    std::vector<std::size_t> trusted;  // numbers of revisits
    double work = 0.0;
  };
  std::optional<NewestSolution> solve_newest(std::size_t from, const Eigen::Matrix3d& known);

  // In map, of the last solution; later nodes are dead reckoned from it.
  const std::vector<PlanarPose>& nodes() const { return nodes_; }
  const std::vector<RevisitEdge>& revisits() const { return revisits_; }
  const std::vector<FixEdge>& fixes() const { return fixes_; }

  // Slip of the step that begins at a node, in the last solution; for the newest node that of the
  // last step.
  double slip(std::size_t from) const;
  // Its prior standard deviation.
  double slip_sigma(std::size_t from) const;
  // Pose in map of a place near a node.
  PlanarPose place(std::size_t node, const PlanarPose& at, const WheelWay& way) const;

 private:
  // Beyond the newest revisit or fix, nothing measures slip. The solver goes on with the last slip
  // there, which is the most probable one; this puts the mean of the slip's prior in its place.
  void predict_newest(const std::vector<bool>& trusted, double scale, std::vector<double>& slips,
                      std::vector<PlanarPose>& nodes) const;

  PoseGraphOptions options_;
  std::vector<PlanarPose> nodes_;
  std::vector<WhitenedStep> steps_;  // steps_[i] leads from node i to node i + 1
  std::vector<double> slips_;        // of the steps, in the last solution
  std::vector<RevisitEdge> revisits_;
  std::vector<bool> trusted_;  // in the last solution, of the revisits that there were
  std::vector<FixEdge> fixes_;
  std::vector<Eigen::Vector2d> lasting_;  // errors of the fixes, in their standard deviations
  std::optional<double> scale_;           // of the last solution
  std::optional<FirstPrior> first_prior_;
};

}  // namespace gprodom
