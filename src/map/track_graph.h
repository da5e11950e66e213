// The track in map: the path driven as a pose graph with its revisits and fixes. It says when the
// graph is solved, and which of its nodes stay.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "gprodom/types.h"
#include "map/fixes/anchor.h"
#include "map/ground_map.h"
#include "map/map_answer.h"
#include "map/pass_merger.h"
#include "map/path/map_path.h"

namespace gprodom {

// How a track lies in its map, where that is known at its start, and how surely: the covariance
// (x, y, yaw, map axes) of the pose of a state before the first one. What the odometry has lost
// from there to the first one is added.
struct TrackStart {
  int map = 0;  // its number
  PlanarPose map_from_track;
  PathState since;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// One end of a revisit: near a node, or fixed in map (kInMap).
struct RevisitEnd {
  std::size_t node = 0;
  PlanarPose body;     // in the node's frame, or in map
  double yaw = 0.0;    // of the body, in map
  WheelWay way;        // the part of `body` that the wheel measured
  PlanarPose antenna;  // in body
};

class TrackGraph {
 public:
  TrackGraph(const SlipModel& slip, std::optional<TrackStart> start);

  // The first of all states begins the graph.
  void follow(const std::vector<PathState>& states);
  bool begun() const { return graph_.has_value(); }

  const MapPath& path() const { return path_; }
  const PoseGraph& graph() const { return *graph_; }
  const SlipModel& slip() const { return slip_; }
  const PlanarEstimate& newest_node() const { return newest_node_; }
  PlanarPose body_at(const MapPath::Place& place) const;
  RevisitEnd end_at(const MapPath::Place& place, const PlanarPose& antenna) const;
  // Of the first node in its map, where the track started there.
  const std::optional<Eigen::Matrix3d>& start_covariance() const { return start_covariance_; }
  // Of the odometry, along the path so far; nothing before the second node. What revisits and other
  // tracks say of it is in the poses, not in this.
  std::optional<PathErrors> errors(double scale_sigma) const;

  // Returns false if both ends lie at the same node, or if the headings contradict the direction.
  bool add_revisit(const RevisitEnd& memory, const RevisitEnd& query, RevisitEdge edge);

  // The whole track, to another frame.
  void move(const PlanarPose& by);
  // The same to site, if a solution with the fixes knows the heading there to yaw_sigma (rad).
  // first: covariance of the first node there, beside the fixes. Returns whether it has moved.
  bool move_to_site(const PlanarPose& by, const Eigen::Matrix3d& first, const ScaleKnown& scale,
                    double yaw_sigma, std::vector<std::string>& notes);
  bool in_site() const { return in_site_; }
  bool solved_in_site() const { return solved_in_site_; }
  void set_fixes(std::vector<FixEdge> fixes) { graph_->set_fixes(std::move(fixes)); }
  // Others are trusted than at the last solution.
  void note_new_fixes() { new_fixes_ = true; }

  // If a solution is due. has_ground: whether ground is stored at a node. Returns true where nodes
  // were removed: then the fixes have to be set anew.
  bool solve_if_due(const ScaleKnown& scale, const std::function<bool(std::size_t)>& has_ground,
                    std::vector<std::string>& notes);
  void solve_soon() { next_solve_ = 0; }

  // The newest settled state, from the first trusted revisit or the first solution in site on.
  std::optional<MapPose> pose() const;
  // m driven at the newest trusted revisit.
  const std::optional<double>& tied_at_m() const { return tied_at_m_; }
  // Variance of the newest position that has come since then, or since the beginning.
  double variance_since_tied_m2() const;

  // How the map deforms the track of odom: a piece for each node, in time order.
  std::vector<TrackPiece> pieces() const;
  // The trusted revisits of the track with itself; those of merged passes only if recorded.
  std::vector<Revisit> revisits() const;
  // Call before the first state: keeps those of merged passes for revisits().
  void record() { record_ = true; }
  // How odom lies in map at the track's beginning.
  PlanarPose map_from_odom() const;
  // Of all solutions so far (NormalMatrix::work()).
  double solve_work() const { return solve_work_; }

 private:
  void begin(const PathState& first);
  void move_newest(const PlanarPose& by);
  void solve(const ScaleKnown& scale, std::vector<std::string>& notes);
  void solve_newest(std::vector<std::string>& notes);
  void note_tie(std::size_t revisit);
  bool merge(const std::function<bool(std::size_t)>& has_ground);
  Revisit told(std::size_t revisit) const;

  const SlipModel slip_;
  const std::optional<TrackStart> start_;
  MapPath path_;
  std::optional<PoseGraph> graph_;
  PlanarEstimate newest_node_;
  Eigen::Vector3d step_variances_ = Eigen::Vector3d::Zero();  // sums: m, m^2, rad^2
  std::optional<Eigen::Matrix3d> start_covariance_;
  bool moved_ = false;                             // to a map, at the start or since
  bool in_site_ = false, solved_in_site_ = false;  // the frame of the graph is site
  bool new_fixes_ = false;                         // since the last solution

  TimeNs next_solve_ = 0, solve_anyway_ = 0, next_newest_ = 0;
  double solved_to_m_ = 0.0;  // travelled at the newest node of the last solution
  Eigen::Matrix3d solved_to_covariance_ = Eigen::Matrix3d::Zero();  // of its pose
  double solve_work_ = 0.0;
  // Travelled; from here on the graph has a new node since the last solution.
  double fresh_at_m_ = 0.0;
  std::vector<bool> trusted_;  // of the graph's revisits, at the last solution
  std::optional<double> tied_at_m_;
  double tied_variance_m2_ = 0.0;  // of the position in map, when that was found

  PassMerger merger_;
  double next_merge_m_ = 0.0;                    // travelled
  int merged_trusted_ = 0, merged_refused_ = 0;  // revisits of passes that were merged
  bool record_ = false;
  std::vector<Revisit> merged_;  // where recorded
};

}  // namespace gprodom
