// The path driven, from settled states of the estimator to steps of the pose graph.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "estimation/nav_state.h"
#include "estimation/state_input.h"

namespace gprodom {

// A state in the plane. Its covariance is that of the error which rotates and shifts all of `odom`
// (nav_state.h). From one state to the next this error grows by the odometry's error alone, so its
// growth is the covariance of the step. The part that the wheel's scale causes is kept apart.
struct PathState {
  TimeNs time = 0;
  PlanarPose pose;  // in odom
  // odom jumps where the estimator learns better of what is past, of a gyro bias say, and the robot
  // has not moved. A pose of odom then, composed with this, is one of a path without jumps: on it,
  // each state follows the one before as one and the same solution has both.
  PlanarPose path_from_odom;
  double scale = 1.0;                                         // with which it was estimated
  Eigen::Vector3d d_scale = Eigen::Vector3d::Zero();          // of the error (x, y, yaw), by scale
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();       // of the error, scale known
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();  // of the pose itself: x, y, yaw
  // Of slip since the state before (slip_model.h): of slip that no witness sees, and of the
  // estimate of slip that the pose is corrected for.
  double slip_sigma = 0.0, believed_slip_sigma = 0.0;
  double unmeasured_slip_sigma = 0.0;  // slip_sigma where no antennas have measured the distance
};

// The newest state, with the uncertainty that it has now.
PathState path_state(const StateResult& newest);
// Moves the state to where a later result has it, with the wheel scale and the slip of that result.
// before: the one that was settled before it.
void settle(PathState& state, const StateResult& result,
            const std::optional<PathState>& before = {});

// A state as it lies in odom when `newer` has been settled.
PathState seen_from(const PathState& newer, const PathState& state);

// The pose of `b` in the frame of `a`, without jumps of odom in between, with the scale of b.
PlanarPose way_between(const PathState& a, const PathState& b);

// Odometry from one to the next.
PlanarStep step_between(const PathState& a, const PathState& b);

// The end of an arc that starts at the origin along x: `along` m long, with `curvature` in rad/m.
PlanarPose along_arc(double along, double curvature);

// m along the track between two nodes of the graph: a patch of ground lies over four of them, and a
// kilometre makes two thousand.
constexpr double kNodeSpacing = 0.5;

class MapPath {
 public:
  explicit MapPath(double node_spacing_m) : node_spacing_m_(node_spacing_m) {}

  // Adds a state, in time order. Returns the step to a new node of the graph if one is due. The
  // first state is node 0.
  std::optional<PlanarStep> add(const PathState& state);

  bool empty() const { return recent_.empty(); }
  const PathState& first() const { return nodes_.front(); }
  const PathState& newest() const { return recent_.back(); }
  double travelled() const { return recent_.back().travelled_m; }
  PlanarStep since_last_node() const { return step(nodes_.back(), recent_.back()); }

  // Signed metres along the track at a time within the last seconds, linear between states. They
  // decrease when the robot drives backwards.
  double distance_at(TimeNs time) const;

  // Metres driven up to a node, unsigned.
  double travelled_at(std::size_t node) const { return nodes_[node].travelled_m; }
  double distance_of(std::size_t node) const { return nodes_[node].distance_m; }
  const PlanarPose& pose_of(std::size_t node) const { return nodes_[node].pose; }  // in odom
  TimeNs time_of(std::size_t node) const { return nodes_[node].time; }
  std::size_t nodes() const { return nodes_.size(); }

  // Removes the other nodes. A node that follows a removed one begins a new piece of the track.
  void keep_only(const std::vector<bool>& nodes);
  bool begins_piece(std::size_t node) const { return nodes_[node].after_gap; }
  // Whether the time lies between two pieces.
  bool is_forgotten(TimeNs time) const;

  // A place on the track: the nearest node, and the pose in that node's frame.
  struct Place {
    std::size_t node = 0;
    PlanarPose at;      // in the node's frame, by the odometry
    WheelWay way;       // the part of `at` that the wheel measured: all of it
    int direction = 1;  // of driving; -1: backwards
  };
  Place place(TimeNs time, double distance_m) const;
  // The same for a time whose distance is not known.
  Place place(TimeNs time) const;

  // The robot at a time within the last seconds, to be compared with other times later on.
  class Mark;
  std::optional<Mark> mark(TimeNs time) const;
  // Odometry from one to the other.
  static PlanarStep way(const Mark& a, const Mark& b);
  // The newest node at that time or before it (the first, if there is none), and the pose there.
  struct MarkAtNode {
    std::size_t node = 0;
    PlanarPose at;
  };
  MarkAtNode at_node(const Mark& mark) const;

 private:
  struct Point : PathState {
    double distance_m = 0.0, travelled_m = 0.0;
    // Sums of the sigmas times distance: deviations if all slip is the same.
    double slip_m = 0.0, believed_slip_m = 0.0;
    bool after_gap = false;  // the node before it was removed
  };
  static PlanarStep step(const Point& a, const Point& b);
  std::size_t nodes_until(TimeNs time) const;
  double node_spacing_m_;
  std::vector<Point> nodes_;
  std::deque<Point> recent_;  // all states of the last seconds
};

class MapPath::Mark {
 public:
  TimeNs time() const { return point_.time; }
  double travelled() const { return point_.travelled_m; }
  const Eigen::Vector2d& velocity() const { return velocity_; }  // of the body, body axes, m/s
  double yaw_rate() const { return yaw_rate_; }                  // rad/s

 private:
  friend class MapPath;
  Mark(const Point& point, const PlanarPose& way, double seconds);
  Point point_;
  Eigen::Vector2d velocity_;
  double yaw_rate_;
};

}  // namespace gprodom
