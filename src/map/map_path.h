// The path driven, from settled states of the estimator to steps of the pose graph.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "estimation/nav_state.h"
#include "estimation/state_estimator.h"

namespace gprodom {

// A state in the plane. The uncertainty is that of the error which turns and shifts the whole of
// `odom` (nav_state.h): between two states it grows by their odometry's error and nothing else, so
// its growth is the covariance of the step. What the scale has to do with it is kept apart.
struct PathState {
  TimeNs time = 0;
  PlanarPose pose;                                            // in odom
  double scale = 1.0;                                         // with which it was estimated
  Eigen::Vector3d d_scale = Eigen::Vector3d::Zero();          // of the error (x, y, yaw), by scale
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();       // of the error, scale known
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();  // of the pose itself: x, y, yaw
  double slip_sigma = 0.0;  // of slip not seen since the state before (slip_model.h)
};

// The uncertainty of a state as it was when it was the newest.
PathState path_state(const StateResult& newest);
// Its place as it was told later, with the scale believed then.
void settle(PathState& state, const NavState& later, double scale);

// Odometry from one to the next.
PlanarStep step_between(const PathState& a, const PathState& b);

// Where an arc from the origin, along x at first, gets to: `along` m, turning by `curvature` rad/m.
PlanarPose along_arc(double along, double curvature);

class MapPath {
 public:
  explicit MapPath(double node_spacing_m) : node_spacing_m_(node_spacing_m) {}

  // In time order. Returns the step to a new node of the graph, where one is due; the first state
  // is node 0.
  std::optional<PlanarStep> add(const PathState& state);

  bool empty() const { return recent_.empty(); }
  const PathState& first() const { return nodes_.front().state; }
  const PathState& newest() const { return recent_.back().state; }
  double travelled() const { return recent_.back().travelled_m; }
  PlanarStep since_last_node() const { return step(nodes_.back(), recent_.back()); }

  // Signed metres along the track, falling when driven backwards; linear between states. Of a time
  // within the last seconds.
  double distance_at(TimeNs time) const;

  // Metres driven up to a node, unsigned.
  double travelled_at(std::size_t node) const { return nodes_[node].travelled_m; }
  double distance_of(std::size_t node) const { return nodes_[node].distance_m; }
  const PlanarPose& pose_of(std::size_t node) const { return nodes_[node].state.pose; }  // in odom
  TimeNs time_of(std::size_t node) const { return nodes_[node].state.time; }
  std::size_t nodes() const { return nodes_.size(); }

  // Forgets nodes; those that follow them begin a piece of their own.
  void keep_only(const std::vector<bool>& nodes);
  bool begins_piece(std::size_t node) const { return nodes_[node].after_gap; }
  // Nothing is known of a time between two pieces.
  bool is_forgotten(TimeNs time) const;

  // A place on the track, by the node nearest to it and where it lies in that node's frame.
  struct Place {
    std::size_t node = 0;
    PlanarPose at;      // by the odometry
    WheelWay way;       // of `at`: all of it
    int direction = 1;  // driven: -1 backwards
  };
  Place place(TimeNs time, double distance_m) const;
  // The same where the distance is not known.
  Place place(TimeNs time) const;

 private:
  struct Point {
    PathState state;
    double distance_m = 0.0, travelled_m = 0.0;
    double slip_m = 0.0;     // sum of slip_sigma times way: what may have slipped, all one way
    bool after_gap = false;  // nodes before it were forgotten
  };
  static PlanarStep step(const Point& a, const Point& b);
  std::size_t nodes_until(TimeNs time) const;
  double node_spacing_m_;
  std::vector<Point> nodes_;
  std::deque<Point> recent_;  // all states of the last seconds
};

}  // namespace gprodom
