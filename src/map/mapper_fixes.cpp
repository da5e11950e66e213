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
// Standard deviations; what is further from where the map places it is in another site, or wrong.
const double kContradicts = PoseGraphOptions{}.drop_beyond;
constexpr double kLeastHeight = 0.01;  // m; nobody knows the height of ground any better
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

// Where the fixes' antennas are by the graph, and the headings of the robot.
std::vector<PlanarPose> Mapper::places_of_fixes(const PlanarPose& site_from_map) const {
  std::vector<PlanarPose> places;
  for (const FixEdge& edge : graph_->fixes())
    places.push_back(compose(site_from_map, graph_->place(edge.node, edge.at, edge.way)));
  return places;
}

// By where the ground that the track lies on was in site, and by the fixes as far as that was not
// known. Nothing where it was not known at all, or where they contradict it.
std::optional<Mapper::SiteTie> Mapper::tie_by_ground() const {
  const auto stored = located_ ? ground_.datums.find(map_) : ground_.datums.end();
  if (stored == ground_.datums.end() || graph_->fixes().empty()) return std::nullopt;
  MapDatum datum = stored->second;
  const Eigen::Matrix3d of_newest =
      turned(newest_node_.covariance.topLeftCorner<3, 3>(), datum.pose.yaw);
  const KnownTie known{carried(planar_block(datum.covariance), -datum.pose.p),
                       carried(of_newest, -compose(datum.pose, newest_node_.pose).p)};
  const RigidTie tie = tie_rigidly(graph_->fixes(), places_of_fixes(datum.pose), known);
  if (tie.worst > kContradicts) return std::nullopt;
  const PlanarPose by = compose(tie.by, datum.pose);
  Eigen::Matrix3d first =
      kNothingKnown.cwiseAbs2().asDiagonal();  // known by the revisits, if they tie it
  if (start_covariance_)
    first = turned(*start_covariance_, by.yaw) +
            carried(tie.covariance, compose(by, graph_->nodes().front()).p);
  datum.pose = {};  // its places are moved
  set_planar_block(tie.covariance, datum.covariance);
  return SiteTie{by, first, datum};
}

std::optional<Mapper::SiteTie> Mapper::tie_by_fixes() const {
  std::vector<PlacePair> pairs;
  const std::vector<PlanarPose> places = places_of_fixes({});
  for (std::size_t i = 0; i < places.size(); ++i) {
    const FixEdge& edge = graph_->fixes()[i];
    PlacePair pair{places[i], edge.p, std::sqrt(0.5 * edge.covariance.trace()), std::nullopt,
                   edge.yaw_sigma};
    if (edge.yaw_sigma > 0.0) pair.heading = edge.yaw;
    pairs.push_back(pair);
  }
  const auto fit = fit_site(pairs);
  if (!fit) return std::nullopt;
  return SiteTie{*fit, kNothingKnown.cwiseAbs2().asDiagonal(), std::nullopt};
}

// From now on `map` is `site`, if a solution with the fixes is sure enough of the heading there.
// Ground of an earlier track that this one lies on goes with it.
void Mapper::tie_to_site(const MapInput& input, MapAnswer& answer) {
  if (path_.nodes() < 2) return;
  const std::optional<SiteTie> by_ground = tie_by_ground();
  const std::optional<SiteTie> tie = by_ground ? by_ground : tie_by_fixes();
  if (!tie) return;
  PoseGraph in_site = *graph_;
  in_site.move(tie->by);
  in_site.set_first_prior(tie->first);
  try {
    const PlanarEstimate newest = in_site.solve(input.scale, input.scale_sigma).newest;
    if (std::sqrt(newest.covariance(2, 2)) > (located_ ? kTieGroundYaw : kTieYaw)) return;
  } catch (const std::runtime_error& error) {
    answer.notes.emplace_back(error.what());
    return;
  }
  const bool had_datum = ground_.datums.erase(map_) > 0;
  if (had_datum && located_ && !by_ground)
    answer.notes.emplace_back(
        "the fixes contradict the place in site that the map had: the map is moved to them");
  if (tie->datum) ground_.datums.emplace(map_, *tie->datum);
  keeps_datum_ = tie->datum.has_value();
  move_ground(map_, tie->by);
  graph_ = std::move(in_site);
  move_newest(tie->by);
  tied_ = moved_ = true;
  next_solve_ = 0;
  answer.tied = true;
}

// Earlier tracks were tied to a site. Its origin is that of this track, too, where nothing else is
// told; where another one is, they are placed by that.
void Mapper::take_datums() {
  for (const auto& [map, datum] : ground_.datums)
    if (datum.origin) fixes_.suppose_origin(*datum.origin);
  if (!fixes_.datum()) return;
  for (auto next = ground_.datums.begin(); next != ground_.datums.end();) {
    const auto here = next++;
    if (!here->second.origin) continue;
    const auto moved = in_site_of(here->second, fixes_.datum()->origin());
    if (moved)
      here->second = *moved;
    else
      ground_.datums.erase(here);
  }
}

// Where the map lies in site, for its file. Ground that has told this itself keeps it: it does not
// move with what this track's fixes say beside it.
void Mapper::note_datum() {
  if (!tied_ || !solved_in_site_ || keeps_datum_ || graph_->fixes().empty()) return;
  MapDatum datum;
  set_planar_block(tie_rigidly(graph_->fixes(), places_of_fixes({}), std::nullopt).covariance,
                   datum.covariance);
  // The plane of the map lies in the ground's mean height: what fixes tell of that beside it is
  // both their error and the ground's slope.
  double mean_square = 0.0, variance = 0.0;
  const auto count = static_cast<double>(fixes_.anchors().size());
  for (const Anchor& anchor : fixes_.anchors()) {
    const double z = anchor.p.z() - anchor.lever_arm.z();
    datum.z += z / count;
    mean_square += z * z / count;
    variance += anchor.covariance(2, 2) / count;
  }
  datum.covariance(2, 2) =
      variance + std::max(0.0, mean_square - datum.z * datum.z) + kLeastHeight * kLeastHeight;
  if (fixes_.datum()) datum.origin = fixes_.datum()->origin();
  ground_.datums.insert_or_assign(map_, datum);
}

// The stored ground of earlier tracks of a map, as a whole.
void Mapper::move_ground(int map, const PlanarPose& by) {
  for (KnownPlace& place : ground_.places) {
    if (place.map != map) continue;
    place.pose = compose(by, place.pose);
    saved_.reset();  // a file of what is new has new places alone
  }
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
    used.push_back(
        {anchor.mark.time(), edges[i], anchor.antenna, anchor.lever_arm, anchor.arm_sigma});
  }
  return used;
}

}  // namespace gprodom
