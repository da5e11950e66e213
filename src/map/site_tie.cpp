#include "map/site_tie.h"

#include <algorithm>
#include <cmath>
#include <utility>

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
constexpr std::size_t kMostWaiting = 2000;

}  // namespace

SiteTie::SiteTie(const AnchorConfig& config, TrackGraph& track, GroundStore& store)
    : track_(track), store_(store), fixes_(config) {
  take_datums();
}

bool SiteTie::take(const MapInput& input, std::vector<std::string>& notes) {
  const std::vector<PositionFix>& fixes = input.fixes;
  if (fixes.empty() && waiting_.empty()) return false;
  waiting_.insert(waiting_.end(), fixes.begin(), fixes.end());
  std::stable_sort(waiting_.begin(), waiting_.end(),
                   [](const PositionFix& a, const PositionFix& b) { return a.time < b.time; });
  const PlanarEstimate& newest = track_.newest_node();
  ScaleKnown scale{input.scale, input.scale_sigma};
  if (track_.solved_in_site()) scale = {newest.scale, std::sqrt(newest.covariance(3, 3))};
  const MapPath& path = track_.path();
  while (!waiting_.empty() &&
         (waiting_.front().time <= path.newest().time || waiting_.size() > kMostWaiting)) {
    const PositionFix fix = waiting_.front();
    waiting_.pop_front();
    if (const auto mark = path.mark(fix.time))
      fixes_.add(fix, *mark, scale);
    else
      notes.emplace_back("a fix is older than the track or than 20 s: not used");
  }
  if (!fixes_.take_change()) return false;
  track_.note_new_fixes();
  place_fixes();
  return !track_.in_site() && tie({input.scale, input.scale_sigma}, notes);
}

std::optional<FixReport> SiteTie::report() const {
  if (!fixes_.any()) return std::nullopt;
  FixReport report;
  report.used = track_.in_site() ? fixes_.anchors().size() : 0;
  report.refused = fixes_.refused();
  report.trouble = fixes_.trouble();
  if (track_.in_site() && fixes_.datum()) report.datum = fixes_.datum()->origin();
  if (track_.solved_in_site()) {
    report.scale = track_.newest_node().scale;
    report.scale_sigma = std::sqrt(track_.newest_node().covariance(3, 3));
  }
  return report;
}

void SiteTie::place_fixes() {
  std::vector<FixEdge> edges;
  for (std::size_t i = 0; i < fixes_.anchors().size(); ++i) {
    const Anchor& anchor = fixes_.anchors()[i];
    const MapPath::MarkAtNode at = track_.path().at_node(anchor.mark);
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
  track_.set_fixes(std::move(edges));
}

// Where the fixes' antennas are by the graph, and the headings of the robot.
std::vector<PlanarPose> SiteTie::places_of_fixes(const PlanarPose& site_from_map) const {
  std::vector<PlanarPose> places;
  for (const FixEdge& edge : track_.graph().fixes())
    places.push_back(compose(site_from_map, track_.graph().place(edge.node, edge.at, edge.way)));
  return places;
}

// By where the ground that the track lies on was in site, and by the fixes as far as that was not
// known. Nothing where it was not known at all, or where they contradict it.
std::optional<SiteTie::Tie> SiteTie::tie_by_ground() const {
  const std::map<int, MapDatum>& datums = store_.ground().datums;
  const std::vector<FixEdge>& fixes = track_.graph().fixes();
  const auto stored = store_.located() ? datums.find(store_.map()) : datums.end();
  if (stored == datums.end() || fixes.empty()) return std::nullopt;
  MapDatum datum = stored->second;
  const PlanarEstimate& newest = track_.newest_node();
  const Eigen::Matrix3d of_newest = turned(newest.covariance.topLeftCorner<3, 3>(), datum.pose.yaw);
  const KnownTie known{carried(planar_block(datum.covariance), -datum.pose.p),
                       carried(of_newest, -compose(datum.pose, newest.pose).p)};
  const RigidTie tie = tie_rigidly(fixes, places_of_fixes(datum.pose), known);
  if (tie.worst > kContradicts) return std::nullopt;
  const PlanarPose by = compose(tie.by, datum.pose);
  Eigen::Matrix3d first =
      kNothingKnown.cwiseAbs2().asDiagonal();  // known by the revisits, if they tie it
  if (track_.start_covariance())
    first = turned(*track_.start_covariance(), by.yaw) +
            carried(tie.covariance, compose(by, track_.graph().nodes().front()).p);
  datum.pose = {};  // its places are moved
  set_planar_block(tie.covariance, datum.covariance);
  return Tie{by, first, datum};
}

std::optional<SiteTie::Tie> SiteTie::tie_by_fixes() const {
  std::vector<PlacePair> pairs;
  const std::vector<PlanarPose> places = places_of_fixes({});
  for (std::size_t i = 0; i < places.size(); ++i) {
    const FixEdge& edge = track_.graph().fixes()[i];
    PlacePair pair{places[i], edge.p, std::sqrt(0.5 * edge.covariance.trace()), std::nullopt,
                   edge.yaw_sigma};
    if (edge.yaw_sigma > 0.0) pair.heading = edge.yaw;
    pairs.push_back(pair);
  }
  const auto fit = fit_site(pairs);
  if (!fit) return std::nullopt;
  return Tie{*fit, kNothingKnown.cwiseAbs2().asDiagonal(), std::nullopt};
}

// From now on `map` is `site`, if a solution with the fixes is sure enough of the heading there.
// Ground of an earlier track that this one lies on goes with it.
bool SiteTie::tie(const ScaleKnown& scale, std::vector<std::string>& notes) {
  if (track_.path().nodes() < 2) return false;
  const std::optional<Tie> by_ground = tie_by_ground();
  const std::optional<Tie> tie = by_ground ? by_ground : tie_by_fixes();
  const bool located = store_.located();
  if (!tie ||
      !track_.move_to_site(tie->by, tie->first, scale, located ? kTieGroundYaw : kTieYaw, notes))
    return false;
  const bool had_datum = store_.datums().erase(store_.map()) > 0;
  if (had_datum && located && !by_ground)
    notes.emplace_back(
        "the fixes contradict the place in site that the map had: the map is moved to them");
  if (tie->datum) store_.datums().emplace(store_.map(), *tie->datum);
  keeps_datum_ = tie->datum.has_value();
  store_.move_places(store_.map(), tie->by);
  return true;
}

// Earlier tracks were tied to a site. Its origin is that of this track, too, where nothing else is
// told; where another one is, they are placed by that.
void SiteTie::take_datums() {
  std::map<int, MapDatum>& datums = store_.datums();
  for (const auto& [map, datum] : datums)
    if (datum.origin) fixes_.suppose_origin(*datum.origin);
  if (!fixes_.datum()) return;
  for (auto next = datums.begin(); next != datums.end();) {
    const auto here = next++;
    if (!here->second.origin) continue;
    const auto moved = in_site_of(here->second, fixes_.datum()->origin());
    if (moved)
      here->second = *moved;
    else
      datums.erase(here);
  }
}

void SiteTie::note_datum() {
  if (!track_.solved_in_site() || keeps_datum_ || track_.graph().fixes().empty()) return;
  MapDatum datum;
  set_planar_block(
      tie_rigidly(track_.graph().fixes(), places_of_fixes({}), std::nullopt).covariance,
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
  store_.datums().insert_or_assign(store_.map(), datum);
}

std::vector<UsedFix> SiteTie::used_fixes() const {
  std::vector<UsedFix> used;
  if (!track_.in_site()) return used;
  const std::vector<FixEdge>& edges = track_.graph().fixes();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Anchor& anchor = fixes_.anchors()[i];
    used.push_back(
        {anchor.mark.time(), edges[i], anchor.antenna, anchor.lever_arm, anchor.arm_sigma});
  }
  return used;
}

}  // namespace gprodom
