#include "map/track_graph.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "map/map_frame.h"

namespace gprodom {
namespace {

constexpr double kSolveEvery = 1.0;       // s of data time, and
constexpr double kSolveEveryNode = 1e-3;  // s of data time a node, so that the work stays bounded
// Where the track has crossed itself again and again, a solution costs far more than by its nodes:
// it may take this much work (NormalMatrix::work()) for each second of data until the next one: a
// twentieth of a core that does 1e9 multiplications a second.
constexpr double kSolveWork = 5e7;
constexpr double kSolveAnyway = 10.0;  // s of data time; solves without a new revisit, since the
                                       // scale is learnt meanwhile
constexpr double kMergeEvery = 5.0;    // m driven

}  // namespace

TrackGraph::TrackGraph(const SlipModel& slip, std::optional<TrackStart> start)
    : slip_(slip), start_(std::move(start)), path_(kNodeSpacing) {}

void TrackGraph::follow(const std::vector<PathState>& states) {
  for (const PathState& state : states) {
    const std::optional<PlanarStep> step = path_.add(state);
    if (!graph_) begin(state);
    if (!step) continue;
    graph_->add_node(*step);
    const Eigen::Vector3d variances = step->covariance.diagonal();
    step_variances_ +=
        Eigen::Vector3d(step->measured.p.norm(), 0.5 * (variances[0] + variances[1]), variances[2]);
    newest_node_ = extend(newest_node_, *step, slip_);
  }
}

void TrackGraph::begin(const PathState& first) {
  PoseGraphOptions options;
  options.slip = slip_;
  graph_.emplace(first.pose, options);
  newest_node_.pose = first.pose;
  if (!start_) return;
  move(start_->map_from_track);
  Correction map_from_odom;
  map_from_odom.q_map_odom =
      Eigen::AngleAxisd(start_->map_from_track.yaw, Eigen::Vector3d::UnitZ());
  Eigen::Matrix3d covariance = carried_covariance(
      map_from_odom, start_->covariance, planar_estimate(start_->since), planar_estimate(first));
  // A pose is known no better than the origin of a track.
  const Eigen::Vector3d least(kOriginPositionSigma, kOriginPositionSigma, kOriginYawSigma);
  covariance.diagonal() += least.cwiseAbs2();
  graph_->set_first_prior(covariance);
  start_covariance_ = covariance;
  newest_node_.covariance.topLeftCorner<3, 3>() = covariance;
}

PlanarPose TrackGraph::body_at(const MapPath::Place& place) const {
  return graph_->place(place.node, place.at, place.way);
}

RevisitEnd TrackGraph::end_at(const MapPath::Place& place, const PlanarPose& antenna) const {
  return {place.node, place.at, graph_->nodes()[place.node].yaw, place.way, antenna};
}

std::optional<PathErrors> TrackGraph::errors(double scale_sigma) const {
  const double metres = step_variances_[0];
  if (metres < kNodeSpacing) return std::nullopt;
  return PathErrors{std::sqrt(step_variances_[1] / metres), std::sqrt(step_variances_[2] / metres),
                    scale_sigma};
}

bool TrackGraph::add_revisit(const RevisitEnd& memory, const RevisitEnd& query, RevisitEdge edge) {
  const bool turned = std::cos(query.yaw - memory.yaw) < 0.0;
  if (memory.node == query.node || turned != edge.mirrored) return false;
  edge.memory = memory.node;
  edge.query = query.node;
  edge.memory_at = compose(memory.body, memory.antenna);
  edge.query_at = compose(query.body, query.antenna);
  edge.memory_way = memory.way;
  edge.query_way = query.way;
  graph_->add_revisit(edge);
  return true;
}

void TrackGraph::move(const PlanarPose& by) {
  graph_->move(by);
  move_newest(by);
  moved_ = true;
  solve_soon();
}

void TrackGraph::move_newest(const PlanarPose& by) {
  newest_node_.pose = compose(by, newest_node_.pose);
  Matrix5d turn = Matrix5d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(by.yaw).toRotationMatrix();
  newest_node_.covariance = turn * newest_node_.covariance * turn.transpose();
}

bool TrackGraph::move_to_site(const PlanarPose& by, const Eigen::Matrix3d& first,
                              const ScaleKnown& scale, double yaw_sigma,
                              std::vector<std::string>& notes) {
  PoseGraph in_site = *graph_;
  in_site.move(by);
  in_site.set_first_prior(first);
  try {
    const PlanarEstimate newest = in_site.solve(scale.scale, scale.sigma).newest;
    if (std::sqrt(newest.covariance(2, 2)) > yaw_sigma) return false;
  } catch (const std::runtime_error& error) {
    notes.emplace_back(error.what());
    return false;
  }
  graph_ = std::move(in_site);
  move_newest(by);
  in_site_ = moved_ = true;
  solve_soon();
  return true;
}

bool TrackGraph::solve_if_due(const ScaleKnown& scale,
                              const std::function<bool(std::size_t)>& has_ground,
                              std::vector<std::string>& notes) {
  const bool more = graph_->revisits().size() > trusted_.size() || (in_site_ && new_fixes_);
  const bool moved = path_.travelled() > fresh_at_m_;  // else the last solution holds
  if ((in_site_ || !graph_->revisits().empty()) && path_.nodes() > 1 &&
      path_.newest().time >= (more ? next_solve_ : solve_anyway_) && (more || moved)) {
    solve(scale, notes);
    return merge(has_ground);
  }
  if (more && path_.newest().time >= next_newest_) solve_newest(notes);
  return false;
}

void TrackGraph::solve(const ScaleKnown& scale, std::vector<std::string>& notes) {
  double every =
      std::max(kSolveEvery, kSolveEveryNode * static_cast<double>(graph_->nodes().size()));
  fresh_at_m_ = path_.travelled() + kNodeSpacing;
  try {
    if (!in_site_) graph_->set_fixes({});
    new_fixes_ = false;
    const PoseGraphSolution solution = graph_->solve(scale.scale, scale.sigma);
    newest_node_ = solution.newest;
    solved_in_site_ = in_site_;
    trusted_ = solution.trusted;
    solve_work_ += solution.work;
    every = std::max(every, solution.work / kSolveWork);
    solved_to_m_ = path_.travelled_at(path_.nodes() - 1);
    solved_to_covariance_ = newest_node_.covariance.topLeftCorner<3, 3>();
    for (std::size_t i = 0; i < trusted_.size(); ++i)
      if (trusted_[i]) note_tie(i);
  } catch (const std::runtime_error& error) {
    notes.emplace_back(error.what());
  }
  next_newest_ = path_.newest().time + from_seconds(kSolveEvery);
  next_solve_ = path_.newest().time + from_seconds(every);
  solve_anyway_ = path_.newest().time + from_seconds(std::max(kSolveAnyway, every));
}

// Of a large graph, solutions come seconds apart. Meanwhile revisits correct the nodes since the
// last one. The covariance stays that of dead reckoning, since the older nodes, which are held,
// have errors too.
void TrackGraph::solve_newest(std::vector<std::string>& notes) {
  next_newest_ = path_.newest().time + from_seconds(kSolveEvery);
  if (trusted_.empty()) return;  // no solution yet
  std::size_t from = path_.nodes() - 1;
  while (from > 0 && path_.travelled_at(from) > solved_to_m_) --from;
  try {
    const auto solution = graph_->solve_newest(from, solved_to_covariance_);
    if (!solution) return;
    newest_node_.pose = solution->newest;
    newest_node_.slip = solution->slip;
    solve_work_ += solution->work;
    for (std::size_t revisit : solution->trusted) note_tie(revisit);
  } catch (const std::exception& error) {
    notes.emplace_back(error.what());
  }
}

void TrackGraph::note_tie(std::size_t revisit) {
  const double at_m = path_.travelled_at(graph_->revisits()[revisit].query);
  if (tied_at_m_ && at_m <= *tied_at_m_) return;
  tied_at_m_ = at_m;
  tied_variance_m2_ = newest_node_.covariance.topLeftCorner<2, 2>().trace();
}

double TrackGraph::variance_since_tied_m2() const {
  const double now = newest_node_.covariance.topLeftCorner<2, 2>().trace();
  return std::max(0.0, now - tied_variance_m2_);
}

std::optional<MapPose> TrackGraph::pose() const {
  const auto trusted = static_cast<int>(std::count(trusted_.begin(), trusted_.end(), true));
  const int refused = static_cast<int>(trusted_.size()) - trusted;
  if (!solved_in_site_ && trusted + merged_trusted_ == 0) return std::nullopt;
  return MapPose{extend(newest_node_, path_.since_last_node(), slip_), path_.newest(),
                 trusted + merged_trusted_, refused + merged_refused_};
}

// Removes nodes of passes over known ground.
bool TrackGraph::merge(const std::function<bool(std::size_t)>& has_ground) {
  if (path_.travelled() < next_merge_m_) return false;
  next_merge_m_ = path_.travelled() + kMergeEvery;
  std::vector<PassMerger::Node> nodes(path_.nodes());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    nodes[i] = {path_.travelled_at(i), has_ground(i), graph_->nodes()[i].p};
  for (const FixEdge& fix : graph_->fixes()) nodes[fix.node].has_fix = true;
  const auto [stay, cut] = merger_.judge(nodes, graph_->revisits(), trusted_);
  if (std::find(stay.begin(), stay.end(), false) == stay.end()) return false;

  std::vector<bool> trusted;  // revisits newer than the last solution are at nodes that stay anyway
  for (std::size_t i = 0; i < trusted_.size(); ++i) {
    const RevisitEdge& edge = graph_->revisits()[i];
    const bool in_map = edge.memory == kInMap;
    if (stay[edge.query] && (in_map || stay[edge.memory])) {
      trusted.push_back(trusted_[i]);
    } else {
      ++(trusted_[i] ? merged_trusted_ : merged_refused_);
      if (record_ && trusted_[i] && !in_map) merged_.push_back(told(i));
    }
  }
  trusted_ = std::move(trusted);
  graph_->keep_only(stay, cut);
  path_.keep_only(stay);
  return true;
}

std::vector<Revisit> TrackGraph::revisits() const {
  std::vector<Revisit> all = merged_;
  for (std::size_t i = 0; i < trusted_.size(); ++i)
    if (trusted_[i] && graph_->revisits()[i].memory != kInMap) all.push_back(told(i));
  return all;
}

Revisit TrackGraph::told(std::size_t revisit) const {
  RevisitEdge edge = graph_->revisits()[revisit];
  const auto as_driven = [&](std::size_t node, const PlanarPose& at, const WheelWay& way) {
    return between(graph_->nodes()[node], graph_->place(node, at, way));
  };
  edge.memory_at = as_driven(edge.memory, edge.memory_at, edge.memory_way);
  edge.query_at = as_driven(edge.query, edge.query_at, edge.query_way);
  edge.memory_way = edge.query_way = {};
  return {path_.time_of(edge.memory), path_.time_of(edge.query), edge};
}

std::vector<TrackPiece> TrackGraph::pieces() const {
  std::vector<TrackPiece> pieces;
  for (std::size_t node = 0; graph_ && node < path_.nodes(); ++node) {
    const bool last = node + 1 == path_.nodes();
    std::optional<double> slip;
    if (graph_->slip_sigma(node) > 0) slip = last ? newest_node_.slip : graph_->slip(node);
    pieces.push_back({path_.time_of(node), path_.pose_of(node), graph_->nodes()[node], slip});
  }
  return pieces;
}

PlanarPose TrackGraph::map_from_odom() const {
  if (!moved_) return {};
  return compose(graph_->nodes().front(), between(path_.first().pose, {}));
}

}  // namespace gprodom
