#include "map/relocation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "map/search_window.h"

namespace gprodom {
namespace {

constexpr double kConfirmWithin = 8.0;  // m driven without proof, then a hypothesis is dropped
constexpr double kAgainWithin = 24.0;   // m driven from a revisit without another, likewise
constexpr double kToldYawSigma = 0.15;  // rad; of a place told, as a hand sets it on a screen
// m driven; own ground of a track that is adrift is older than what it is compared with, 10 m, and
// all that the searches about it cover.
constexpr double kNewestGround = 30.0;
constexpr double kSupposeEvery = 1.0;  // m between two choices of a change near a place told

}  // namespace

Relocation::Relocation(const GraphConfig& config, const TrackGraph& track, const GroundStore& store)
    : patch_length_m_(config.patch_length), track_(track), store_(store) {}

bool Relocation::suppose(const ToldPlace& told, std::vector<std::string>& notes) {
  std::map<int, std::size_t> places;
  for (const KnownPlace& place : store_.ground().places) ++places[place.map];
  const auto most =
      std::max_element(places.begin(), places.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const RoughPlace& place = told.place;
  const int map = place.map < 0 && most != places.end() ? most->first : place.map;
  if (store_.located()) {
    notes.emplace_back("locate_at: not used: the track is located already; reset first");
    return false;
  }
  if (places.count(map) == 0) {
    notes.emplace_back("locate_at: not used: there is no earlier ground, or no map of that number");
    return false;
  }
  const PlanarPose since = between(told.in_odom, track_.path().newest().pose);
  const PlanarPose in_map = compose({{place.x, place.y}, place.yaw}, since);
  Candidate candidate;
  candidate.at = {compose(in_map, between(track_.newest_node().pose, {})), map, {}};
  candidate.told_sigma_m = place.sigma_m;
  candidate.from_m = track_.path().travelled();
  candidate.until_m = candidate.from_m + kConfirmWithin + kGateSigmas * place.sigma_m;
  candidate_ = std::move(candidate);
  change_.believe({});
  return true;
}

double Relocation::sigma_m() const {
  const double odometry = std::sqrt(track_.newest_node().covariance.topLeftCorner<2, 2>().trace());
  if (!candidate_ || candidate_->told_sigma_m == 0.0) return odometry;
  const double turned = kToldYawSigma * (track_.path().travelled() - candidate_->from_m);
  return std::hypot(odometry, std::hypot(candidate_->told_sigma_m, turned));
}

// Whether the track may be so far off in an earlier map that the searches about it miss its ground.
bool Relocation::is_lost() const {
  if (!store_.located()) return store_.memory().kept().first < store_.end_of_before();
  return sigma_m() > kLostSigma;
}

// The same of the track's own ground: what the odometry may have lost since the newest revisit, or
// since the beginning.
bool Relocation::is_adrift() const {
  return std::sqrt(track_.variance_since_tied_m2()) > kLostSigma;
}

// The track's own ground but the newest.
OwnGround Relocation::own_ground() const {
  const MapPath& path = track_.path();
  std::size_t node = path.nodes() - 1;
  while (node > 0 && path.travelled_at(node) > path.travelled() - kNewestGround) --node;
  const auto last = store_.memory().column_at(path.time_of(node), store_.end_of_before());
  return {last.value_or(0), [this](double column) { return place_of(column); }};
}

// Of a column of the track's own ground; nothing where it is forgotten.
std::optional<GroundMap::At> Relocation::place_of(double column) const {
  if (column < static_cast<double>(store_.memory().kept().first)) return std::nullopt;
  const std::optional<RevisitEnd> end = store_.end_at(column, track_);
  if (!end) return std::nullopt;
  return GroundMap::At{track_.graph().place(end->node, end->body, end->way), store_.map()};
}

bool Relocation::locate(std::vector<std::string>& notes) {
  const double travelled = track_.path().travelled();
  const bool adrift = is_adrift();
  if (!is_lost() && !adrift) {
    candidate_.reset();
    return false;
  }
  if (!locator_.is_due(travelled)) return false;
  const bool was_told = candidate_ && candidate_->told_sigma_m > 0.0;
  if (candidate_ && travelled < candidate_->until_m) return was_told && suppose_change();
  if (was_told)
    notes.emplace_back("locate_at: the ground there is not the one driven over: not located");
  candidate_.reset();
  const auto newest = Locator::last_searched(store_.memory(), store_.end_of_before());
  if (!newest) return false;
  const PlanarPose body = track_.body_at(track_.path().place(newest->time, newest->distance_m));
  OwnGround own = own_ground();
  if (!adrift) own.end = 0;
  const auto found = locator_.find(store_.ground(), store_.end_of_before(), body, store_.antenna(),
                                   travelled, own);
  if (!found || ((store_.located() || found->own) && !may_be(*found, body))) return false;
  Candidate candidate;
  candidate.at = *found;
  candidate.from_m = travelled;
  candidate.until_m = travelled + kConfirmWithin;
  candidate_ = std::move(candidate);
  if (!found->own) change_.believe(found->change);
  return true;
}

// Whether the track can be there: in its map, and as far from its pose as that is uncertain.
bool Relocation::may_be(const Hypothesis& found, const PlanarPose& body) const {
  constexpr double kMostSigmas = 4.0;  // one more than searched: the covariance may be too small
  constexpr double kCrossing = 0.5;    // rad between the tracks of one place (PassFinder)
  const double yaw_variance = track_.newest_node().covariance(2, 2);
  const PlanarPose there = compose(found.map_from_track, body);
  return found.map == store_.map() && (there.p - body.p).norm() <= kMostSigmas * sigma_m() &&
         std::abs(std::remainder(there.yaw - body.yaw, 2 * M_PI)) <=
             kCrossing + kMostSigmas * std::sqrt(yaw_variance);
}

// How the ground has changed is not told with a place. So the change that fits best near there is
// supposed, again and again, until the place is proved.
bool Relocation::suppose_change() {
  const double travelled = track_.path().travelled();
  if (!store_.memory().can_undo() || travelled < candidate_->next_change_m) return false;
  candidate_->next_change_m = travelled + kSupposeEvery;
  const Hypothesis& at = candidate_->at;
  const PlanarPose here = compose(at.map_from_track, track_.newest_node().pose);
  const double gate = std::min(kGateSigmas * sigma_m(), kGateMax);
  const auto best =
      Locator::change_near(store_.ground(), store_.end_of_before(), {at.map, here.p, gate});
  const gpr::TraceChange& now = change_.change();
  if (!best || (best->stretch == now.stretch && best->turn == now.turn)) return false;
  change_.believe(*best);
  return true;
}

bool Relocation::speaks_for_candidate(const RevisitEnd& memory,
                                      const gpr::MemoryColumn& query) const {
  if (!candidate_) return false;
  if (!candidate_->at.own) return memory.node == kInMap;
  if (memory.node == kInMap) return false;
  const Eigen::Vector2d then = track_.graph().place(memory.node, memory.body, memory.way).p;
  const PlanarPose here = track_.body_at(track_.path().place(query.time, query.distance_m));
  const PlanarPose there = compose(candidate_->at.map_from_track, here);
  return (then - there.p).norm() < (then - here.p).norm();
}

std::optional<Relocation::Candidate> Relocation::support(const Sighting& seen) {
  const MapPath::Place query = track_.path().place(seen.query.time, seen.query.distance_m);
  const double yaw = track_.end_at(query, seen.antenna).yaw + candidate_->at.map_from_track.yaw;
  if ((std::cos(yaw - seen.memory.yaw) < 0.0) != seen.edge.mirrored) return std::nullopt;
  candidate_->supporting.push_back(seen);
  if (!is_proved()) return std::nullopt;
  return std::exchange(candidate_, std::nullopt);
}

// A place that was found is the best of a great many, and a drive over other ground tries many such
// places. So one revisit does not prove it: it needs another one whose patch has none of the
// ground of the first.
bool Relocation::is_proved() {
  if (candidate_->told_sigma_m > 0.0) return true;
  const double travelled = track_.path().travelled();
  if (!candidate_->supported_m) {
    candidate_->supported_m = travelled;
    candidate_->until_m = travelled + kAgainWithin;
  }
  return travelled - *candidate_->supported_m >= patch_length_m_;
}

}  // namespace gprodom
