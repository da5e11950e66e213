// Mapper: positions from outside tie the graph to `site`. docs/anchors.md.
#include <algorithm>
#include <cmath>
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
// The track has moved on, or a fix waits for its state, within the path's recent states.
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
  answer.fixes = FixReport{fixes_.anchors().size(), fixes_.refused(), fixes_.trouble()};
  if (!fixes_.take_change()) return;
  fixes_changed_ = true;
  place_fixes();
  if (!tied_) tie_to_site(answer);
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
    edge.covariance = fixes_.covariance_alone(i);
    if (anchor.heading) {
      edge.yaw = *anchor.heading;
      edge.yaw_sigma = anchor.heading_sigma;
    }
    edges.push_back(edge);
  }
  graph_->set_fixes(std::move(edges));
}

// From now on `map` is `site`. Ground of an earlier track that this one lies on goes with it.
void Mapper::tie_to_site(MapAnswer& answer) {
  std::vector<PlacePair> pairs;
  for (const FixEdge& edge : graph_->fixes()) {
    PlacePair pair{graph_->place(edge.node, edge.at, edge.way), edge.p,
                   std::sqrt(0.5 * edge.covariance.trace()), std::nullopt, edge.yaw_sigma};
    if (edge.yaw_sigma > 0.0) pair.heading = edge.yaw;
    pairs.push_back(pair);
  }
  const auto fit = fit_site(pairs);
  if (!fit || fit->yaw_sigma > (located_ ? kTieGroundYaw : kTieYaw)) return;
  const PlanarPose& T = fit->site_from_track;
  move_ground(map_, T);
  graph_->move(T);
  graph_->set_first_prior(
      Eigen::Vector3d(kFreePlace, kFreePlace, kFreeYaw).cwiseAbs2().asDiagonal());
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
  for (std::size_t i = 0; tied_ && i < fixes_.anchors().size(); ++i) {
    const Anchor& anchor = fixes_.anchors()[i];
    used.push_back(
        {anchor.mark.time(), anchor.p.head<2>(), fixes_.covariance_alone(i), anchor.lever_arm});
  }
  return used;
}

}  // namespace gprodom
