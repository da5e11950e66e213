// Mapper: positions from outside tie the graph to `site`. docs/anchors.md.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "map/mapper.h"

namespace gprodom {
namespace {

// rad; map turns to site as soon as its heading there is known to this.
constexpr double kTieYaw = 0.1;
// rad; and ground of an earlier track, which then lies as it lies, to this.
constexpr double kTieGroundYaw = 0.02;
// Of the first node's pose in site, beside the fixes: nothing is known. m and rad.
constexpr double kFreePlace = 1e4, kFreeYaw = 3.0;
// Fixes that wait for a state as new as they are; a receiver at 100 Hz fills them in 20 s.
constexpr std::size_t kMostFixesWaiting = 2000;

}  // namespace

void Mapper::take_fixes(const MapInput& input, MapAnswer& answer) {
  const std::vector<PositionFix>& fixes = input.fixes;
  if (fixes.empty() && waiting_fixes_.empty()) return;
  waiting_fixes_.insert(waiting_fixes_.end(), fixes.begin(), fixes.end());
  std::stable_sort(waiting_fixes_.begin(), waiting_fixes_.end(),
                   [](const PositionFix& a, const PositionFix& b) { return a.time < b.time; });
  ScaleKnown scale{input.scale, input.scale_sigma};
  if (solved_in_site_) scale = {newest_node_.scale, std::sqrt(newest_node_.covariance(3, 3))};
  while (!waiting_fixes_.empty() && (waiting_fixes_.front().time <= path_.newest().time ||
                                     waiting_fixes_.size() > kMostFixesWaiting)) {
    const PositionFix fix = waiting_fixes_.front();
    waiting_fixes_.pop_front();
    if (const auto mark = path_.mark(fix.time))
      fixes_.add(fix, *mark, scale);
    else
      answer.notes.emplace_back("a fix is older than the track or than 20 s: not used");
  }
  if (!fixes_.take_change()) return;
  fixes_changed_ = true;
  place_fixes();
  if (!tied_) tie_to_site(input, answer);
}

FixReport Mapper::fix_report() const {
  FixReport report;
  report.used = tied_ ? fixes_.anchors().size() : 0;
  report.refused = fixes_.refused();
  report.trouble = fixes_.trouble();
  if (tied_ && fixes_.datum()) report.datum = fixes_.datum()->origin();
  if (solved_in_site_) {
    report.scale = newest_node_.scale;
    report.scale_sigma = std::sqrt(newest_node_.covariance(3, 3));
  }
  return report;
}

// The fixes as edges at the nodes that the track has now.
void Mapper::place_fixes() {
  std::vector<FixEdge> edges;
  for (std::size_t i = 0; i < fixes_.anchors().size(); ++i) {
    const Anchor& anchor = fixes_.anchors()[i];
    const MapPath::MarkAtNode at = path_.at_node(anchor.mark);
    FixEdge edge;
    edge.node = at.node;
    edge.at = {compose(at.at, {anchor.lever_arm.head<2>(), 0.0}).p, at.at.yaw};
    edge.way = {at.at.p, false};
    edge.p = anchor.p.head<2>();
    const FixError error = fix_error(anchor);
    edge.covariance = error.covariance;
    edge.white = error.white;
    edge.before = fixes_.before(i);
    if (edge.before) edge.kept = kept_between(fixes_.anchors()[*edge.before], anchor);
    if (anchor.heading) {
      edge.yaw = *anchor.heading;
      edge.yaw_sigma = anchor.heading_sigma;
    }
    edges.push_back(edge);
  }
  graph_->set_fixes(std::move(edges));
}

// From now on `map` is `site`, if a solution with the fixes is sure enough of the heading there.
// Ground of an earlier track that this one lies on goes with it.
void Mapper::tie_to_site(const MapInput& input, MapAnswer& answer) {
  std::vector<PlacePair> pairs;
  for (const FixEdge& edge : graph_->fixes()) {
    PlacePair pair{graph_->place(edge.node, edge.at, edge.way), edge.p,
                   std::sqrt(0.5 * edge.covariance.trace()), std::nullopt, edge.yaw_sigma};
    if (edge.yaw_sigma > 0.0) pair.heading = edge.yaw;
    pairs.push_back(pair);
  }
  const auto fit = fit_site(pairs);
  if (!fit || path_.nodes() < 2) return;
  const PlanarPose& T = *fit;
  PoseGraph in_site = *graph_;
  in_site.move(T);
  in_site.set_first_prior(
      Eigen::Vector3d(kFreePlace, kFreePlace, kFreeYaw).cwiseAbs2().asDiagonal());
  try {
    const PlanarEstimate newest = in_site.solve(input.scale, input.scale_sigma).newest;
    if (std::sqrt(newest.covariance(2, 2)) > (located_ ? kTieGroundYaw : kTieYaw)) return;
  } catch (const std::runtime_error& error) {
    answer.notes.emplace_back(error.what());
    return;
  }
  move_ground(map_, T);
  graph_ = std::move(in_site);
  move_newest(T);
  tied_ = moved_ = true;
  next_solve_ = 0;
  answer.tied = true;
}

// The stored ground of earlier tracks of a map, as a whole.
void Mapper::move_ground(int map, const PlanarPose& by) {
  for (KnownPlace& place : ground_.places)
    if (place.map == map) place.pose = compose(by, place.pose);
}

void Mapper::move_newest(const PlanarPose& by) {
  newest_node_.pose = compose(by, newest_node_.pose);
  Matrix5d turn = Matrix5d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(by.yaw).toRotationMatrix();
  newest_node_.covariance = turn * newest_node_.covariance * turn.transpose();
}

std::vector<UsedFix> Mapper::used_fixes() const {
  std::vector<UsedFix> used;
  const std::vector<FixEdge>& edges = graph_ ? graph_->fixes() : std::vector<FixEdge>();
  for (std::size_t i = 0; tied_ && i < edges.size(); ++i) {
    const Anchor& anchor = fixes_.anchors()[i];
    UsedFix fix;
    fix.time = anchor.mark.time();
    fix.p = edges[i].p - graph_->lasting_error(i);
    fix.covariance = edges[i].white * edges[i].covariance;
    fix.antenna = anchor.lever_arm;
    used.push_back(fix);
  }
  return used;
}

}  // namespace gprodom
