#include "map/merge/track_joint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "map/pass_finder.h"
#include "map/path/map_path.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

using Eigen::Vector2d;

// Errors of the steps of a finished map are those of the odometry along its path; more than this
// even of neighbours, as poses are rounded and columns lie between states.
constexpr double kTieLeastPosition = 1e-3, kTieLeastYaw = 1e-4;
constexpr double kPieces = 0.05;  // m, more between two pieces of a track

// Error of a predicted place: at a tie, and by the distance from it, where the heading counts most.
constexpr double kAtTie = 0.2, kFromTie = 0.05;

constexpr double kSolveEvery_m = 2.0;       // m driven, and
constexpr double kSolveEveryNode_m = 2e-3;  // m a node, so that the work stays bounded
constexpr std::size_t kMostWindows = 2;

PlanarStep step_from(const PlanarPose& a, const PlanarPose& b, bool gap, double scale_share,
                     const PathErrors& errors) {
  PlanarStep step;
  step.measured = between(a, b);
  step.d_scale.head<2>() = scale_share * step.measured.p;
  const double distance = step.measured.p.norm();
  const double position = errors.position * errors.position * distance +
                          kTieLeastPosition * kTieLeastPosition + (gap ? kPieces * kPieces : 0.0);
  const double yaw = errors.yaw * errors.yaw * distance + kTieLeastYaw * kTieLeastYaw;
  step.covariance = Eigen::Vector3d(position, position, yaw).asDiagonal();
  return step;
}

}  // namespace

TrackJoint::TrackJoint(const GroundMap& ground, int joining, std::vector<gpr::MemoryRange> runs,
                       const Hypothesis& at, std::size_t seen, const GraphConfig& config)
    : ground_(ground),
      config_(config),
      runs_(std::move(runs)),
      there_(track_of(at.map)),
      here_(track_of(joining)),
      search_(*ground.memory.filter(), ground.memory.spacing(), search_options(config, true)),
      seen_(ground.at(static_cast<double>(seen), 2 * kNodeSpacing)->pose.p) {
  change_.believe(at.change);
  ratio_sigma_ = std::hypot(scale_sigma(there_), scale_sigma(here_));
  PoseGraphOptions options;
  graph_.emplace(there_.places.front().pose, options);
  // Each track takes half of the ratio of their scales.
  add_track(there_, -0.5);
  // Where the track lies on the other is not known but for the hypothesis.
  const PlanarPose begin = compose(at.map_from_track, here_.places.front().pose);
  PlanarStep loose;
  loose.measured = between(there_.places.back().pose, begin);
  loose.covariance = Eigen::Vector3d(1e4, 1e4, 10.0).asDiagonal();
  here_.node = graph_->add_node(loose);
  add_track(here_, 0.5);
}

const PathErrors& TrackJoint::errors_at(std::size_t column) const {
  return ground_.origins.at(ground_.memory.session_of(column)).errors;
}

// Of the wheel's scale along a track: that of its worst session.
double TrackJoint::scale_sigma(const Track& track) const {
  double sigma = 0.0;
  for (const KnownPlace& place : track.places)
    sigma = std::max(sigma, errors_at(place.column).scale);
  return sigma;
}

TrackJoint::Track TrackJoint::track_of(int map) const {
  Track track;
  std::copy_if(ground_.places.begin(), ground_.places.end(), std::back_inserter(track.places),
               [map](const KnownPlace& place) { return place.map == map; });
  return track;
}

// The places after the first one.
void TrackJoint::add_track(const Track& track, double scale_share) {
  const gpr::TraceMemory& memory = ground_.memory;
  for (std::size_t i = 1; i < track.places.size(); ++i) {
    const KnownPlace &a = track.places[i - 1], &b = track.places[i];
    const bool gap = memory.run_of(a.column).first != memory.run_of(b.column).first;
    graph_->add_node(step_from(a.pose, b.pose, gap, scale_share, errors_at(b.column)));
  }
}

void TrackJoint::sweep(std::size_t first, double give_up_m) {
  since_found_m_ = 0.0;
  for (const gpr::MemoryRange& run : runs_) {
    if (run.end <= first) continue;
    search_run(run, first, give_up_m);
    if (since_found_m_ > give_up_m) break;
  }
  solve();
}

void TrackJoint::search_run(gpr::MemoryRange run, std::size_t first, double give_up_m) {
  const auto patch = static_cast<std::size_t>(search_.patch_columns());
  const auto every =
      static_cast<std::size_t>(std::lround(kQuerySpacing / ground_.memory.spacing()));
  search_.forget();
  double moved = config_.patch_length;
  for (std::size_t end = std::max(first, run.first) + patch; end <= run.end; end += every) {
    const bool found = search_at(run, end, moved);
    moved = kQuerySpacing;
    since_solved_m_ += kQuerySpacing;
    since_found_m_ = found ? 0.0 : since_found_m_ + kQuerySpacing;
    if (since_found_m_ > give_up_m) return;
    const double nodes = static_cast<double>(graph_->nodes().size());
    if (found && since_solved_m_ >= std::max(kSolveEvery_m, kSolveEveryNode_m * nodes)) solve();
  }
}

// Of the newest patch before column `end`. Returns whether the joint knows a place for it.
bool TrackJoint::search_at(gpr::MemoryRange run, std::size_t end, double moved_m) {
  const gpr::TraceMemory& memory = ground_.memory;
  const auto patch = static_cast<std::size_t>(search_.patch_columns());
  const std::size_t middle = end - 1 - patch / 2;
  const auto is_tied = [&](const Tie& tie) { return tie.column == middle; };
  const std::optional<End> here = end_at(here_, static_cast<double>(middle));
  const bool known = std::any_of(ties_.begin(), ties_.end(), is_tied);
  if (known || !here) {
    search_.forget();
    return known;
  }
  const double gate =
      kGateSigmas * sigma_at(ground_.at(static_cast<double>(middle), 2 * kNodeSpacing)->pose.p);
  if (gate > kGateMax) {
    search_.forget();
    return false;
  }
  gpr::MemoryColumn query = memory.column(middle);
  const std::vector<gpr::SearchWindow> near = windows(query, here->now, std::max(gate, kGateMin));
  if (near.empty()) {
    search_.forget();
    return false;
  }
  const std::size_t before = std::min<std::size_t>(kBefore, end - patch - run.first);
  const auto features = [&](const gpr::TraceChange& change, std::size_t columns) {
    return memory.patch({end - columns, end}, change);
  };
  bool found = false;
  for (const gpr::PlaceFound& place :
       search_.find(features(change_.change(), patch + before), moved_m, near)) {
    if (!tie(place, middle, moved_m)) continue;
    found = true;
    change_.follow(memory, place.column,
                   [&](const gpr::TraceChange& tried) { return features(tried, patch); });
  }
  return found;
}

std::vector<gpr::SearchWindow> TrackJoint::windows(const gpr::MemoryColumn& query,
                                                   const PlanarPose& here, double gate_m) const {
  const double aside = kLateralGate + std::min(gate_m, kGateMax);
  PassFinder finder(here, gate_m + kNodeSpacing, aside, 0.0);
  for (std::size_t i = 0; i < there_.places.size(); ++i) {
    const PlanarPose& antenna = graph_->nodes()[i];
    if (finder.may_be_near(antenna)) finder.offer(i, antenna, true);
  }
  std::vector<Pass> passes = in_search_order(finder.passes(), config_.lateral_sigma);
  passes.resize(std::min(passes.size(), kMostWindows));
  std::vector<gpr::SearchWindow> windows;
  for (const Pass& pass : passes) {
    const KnownPlace& place = there_.places[pass.place];
    const gpr::MemoryColumn then = ground_.memory.column(place.column);
    windows.push_back(window_on(ground_.memory, place.column,
                                place.distance_m + pass.along - then.distance_m, gate_m,
                                search_.reach_m()));
    windows.back().mirrored = pass.turned != (then.direction != query.direction);
  }
  return windows;
}

// A column of a track, by the nearest place of it; nothing if none is in reach.
std::optional<TrackJoint::End> TrackJoint::end_at(const Track& track, double column) const {
  const auto own = ground_.at(column, 2 * kNodeSpacing);
  if (!own || track.places.front().map != own->map) return std::nullopt;
  const auto after = std::partition_point(
      track.places.begin(), track.places.end(),
      [column](const KnownPlace& p) { return static_cast<double>(p.column) <= column; });
  auto nearest = after == track.places.begin() ? after : after - 1;
  const auto apart = [&](auto i) { return std::abs(static_cast<double>(i->column) - column); };
  if (after != track.places.end() && apart(after) < apart(nearest)) nearest = after;
  const std::size_t node = track.node + static_cast<std::size_t>(nearest - track.places.begin());
  const PlanarPose at = between(nearest->pose, own->pose);
  return End{node, at, compose(graph_->nodes()[node], at)};
}

bool TrackJoint::tie(const gpr::PlaceFound& found, std::size_t query, double moved_m) {
  // Of an even number of columns, the middle lies between two.
  const double middle = static_cast<double>(query) + 0.5 * (1 - search_.patch_columns() % 2);
  const auto there = end_at(there_, found.column), here = end_at(here_, middle);
  if (!there || !here) return false;
  const gpr::MemoryColumn then = ground_.memory.column(static_cast<std::size_t>(found.column));
  const gpr::MemoryColumn now = ground_.memory.column(query);
  RevisitEdge edge = edge_of(found.match, moved_m, config_);
  edge.mirrored = found.match.mirrored == (then.direction == now.direction);
  if ((std::cos(here->now.yaw - there->now.yaw) < 0.0) != edge.mirrored) return false;
  edge.memory = there->node;
  edge.query = here->node;
  edge.memory_at = there->at;
  edge.query_at = here->at;
  graph_->add_revisit(edge);
  ties_.push_back({query, ground_.at(static_cast<double>(query), 2 * kNodeSpacing)->pose.p});
  return true;
}

// Standard deviation of a predicted place of the joining track, given in its own frame.
double TrackJoint::sigma_at(const Vector2d& own) const {
  double nearest = (own - seen_).norm();
  if (!ties_.empty()) nearest = std::numeric_limits<double>::max();
  for (const Tie& tie : ties_) nearest = std::min(nearest, (own - tie.at).norm());
  return kAtTie + kFromTie * nearest;
}

void TrackJoint::solve() {
  since_solved_m_ = 0.0;
  if (ties_.empty()) return;
  try {
    solution_ = graph_->solve(1.0, ratio_sigma_);
  } catch (const std::runtime_error&) {  // no solution: what was found contradicts itself
    solution_.reset();
  }
}

JoinedTracks TrackJoint::result() {
  JoinedTracks joined;
  joined.change = change_.change();
  if (!solution_) return joined;
  for (std::size_t i = 0; i < ties_.size(); ++i)
    joined.revisits.push_back({ties_[i].column, solution_->trusted[i]});
  std::sort(joined.revisits.begin(), joined.revisits.end(),
            [](const Revisited& a, const Revisited& b) { return a.column < b.column; });
  std::optional<std::size_t> last;
  for (const Revisited& one : joined.revisits) {
    if (!one.trusted) continue;
    const double moved = last ? static_cast<double>(one.column - *last) * ground_.memory.spacing()
                              : config_.patch_length;
    joined.proven_m += std::min(moved, config_.patch_length);
    last = one.column;
  }
  const auto take = [&](const Track& track) {
    for (std::size_t i = 0; i < track.places.size(); ++i) {
      joined.places.push_back(track.places[i]);
      joined.places.back().pose = solution_->nodes[track.node + i];
      joined.places.back().map = there_.places.front().map;
    }
  };
  take(there_);
  take(here_);
  joined.end = solution_->newest;
  // No revisit tells the mean of the two scales.
  const Vector2d way = 0.5 * ratio_sigma_ * (joined.end.pose.p - solution_->nodes.front().p);
  joined.end.covariance.topLeftCorner<2, 2>() += way * way.transpose();
  return joined;
}

}  // namespace gprodom
