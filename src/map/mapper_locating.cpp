// Mapper: where the track lies in the map of an earlier one.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "map/mapper.h"

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

// A hypothesis as told, in place of a found one. Only a revisit proves it.
void Mapper::suppose(const ToldPlace& told, MapAnswer& answer) {
  std::map<int, std::size_t> places;
  for (const KnownPlace& place : ground_.places) ++places[place.map];
  const auto most =
      std::max_element(places.begin(), places.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const RoughPlace& place = told.place;
  const int map = place.map < 0 && most != places.end() ? most->first : place.map;
  if (located_) {
    answer.notes.emplace_back("locate_at: not used: the track is located already; reset first");
    return;
  }
  if (places.count(map) == 0) {
    answer.notes.emplace_back(
        "locate_at: not used: there is no earlier ground, or no map of that number");
    return;
  }
  const PlanarPose since = between(told.in_odom, path_.newest().pose);
  const PlanarPose in_map = compose({{place.x, place.y}, place.yaw}, since);
  Candidate candidate;
  candidate.at = {compose(in_map, between(newest_node_.pose, {})), map, {}};
  candidate.told_sigma_m = place.sigma_m;
  candidate.from_m = path_.travelled();
  candidate.until_m = candidate.from_m + kConfirmWithin + kGateSigmas * place.sigma_m;
  candidate_ = std::move(candidate);
  change_.believe({});
  forget_searches();
}

// Standard deviation of the position now, in the frame of the candidate if there is one.
double Mapper::sigma_m() const {
  const double odometry = std::sqrt(newest_node_.covariance.topLeftCorner<2, 2>().trace());
  if (!candidate_ || candidate_->told_sigma_m == 0.0) return odometry;
  const double turned = kToldYawSigma * (path_.travelled() - candidate_->from_m);
  return std::hypot(odometry, std::hypot(candidate_->told_sigma_m, turned));
}

// Whether the track may be so far off in an earlier map that the searches about it miss its ground.
bool Mapper::is_lost() const {
  if (!located_) return ground_.memory.kept().first < end_of_before_;
  return kGateSigmas * sigma_m() > kGateMax;
}

// The same of the track's own ground: what the odometry may have lost since the newest revisit, or
// since the beginning.
bool Mapper::is_adrift() const {
  const double variance_m2 = newest_node_.covariance.topLeftCorner<2, 2>().trace();
  return kGateSigmas * std::sqrt(std::max(0.0, variance_m2 - tied_variance_m2_)) > kGateMax;
}

// The track's own ground but the newest.
OwnGround Mapper::own_ground() const {
  std::size_t node = path_.nodes() - 1;
  while (node > 0 && path_.travelled_at(node) > path_.travelled() - kNewestGround) --node;
  const auto last = ground_.memory.column_at(path_.time_of(node), end_of_before_);
  return {last.value_or(0), [this](double column) { return place_of(column); }};
}

// Of a column of the track's own ground; nothing where it is forgotten.
std::optional<GroundMap::At> Mapper::place_of(double column) const {
  if (column < static_cast<double>(ground_.memory.kept().first)) return std::nullopt;
  const std::optional<End> end = remembered_end(column);
  if (!end) return std::nullopt;
  return GroundMap::At{graph_->place(end->node, end->body, end->way), map_};
}

// Searches all ground: that of earlier tracks until the track is located, and where it is lost; its
// own where it is adrift.
void Mapper::locate(MapAnswer& answer) {
  const double travelled = path_.travelled();
  const bool adrift = is_adrift();
  if (!is_lost() && !adrift) {
    candidate_.reset();
    return;
  }
  if (!locator_.is_due(travelled)) return;
  const bool was_told = candidate_ && candidate_->told_sigma_m > 0.0;
  if (candidate_ && travelled < candidate_->until_m) {
    if (was_told) suppose_change();
    return;
  }
  if (was_told)
    answer.notes.emplace_back(
        "locate_at: the ground there is not the one driven over: not located");
  candidate_.reset();
  const auto newest = Locator::last_searched(ground_.memory, end_of_before_);
  if (!newest) return;
  const MapPath::Place place = path_.place(newest->time, newest->distance_m);
  const PlanarPose body = body_at(place);
  OwnGround own = own_ground();
  if (!adrift) own.end = 0;
  const auto found = locator_.find(ground_, end_of_before_, body, seeker_.antenna, travelled, own);
  if (!found || ((located_ || found->own) && !may_be(*found, body))) return;
  Candidate candidate;
  candidate.at = *found;
  candidate.from_m = travelled;
  candidate.until_m = travelled + kConfirmWithin;
  candidate_ = std::move(candidate);
  if (!found->own) change_.believe(found->change);
  forget_searches();
}

// Whether the track can be there: in its map, and as far from its pose as that is uncertain.
bool Mapper::may_be(const Hypothesis& found, const PlanarPose& body) const {
  constexpr double kMostSigmas = 4.0;  // one more than searched: the covariance may be too small
  constexpr double kCrossing = 0.5;    // rad between the tracks of one place (PassFinder)
  const Eigen::Matrix3d covariance = newest_node_.covariance.topLeftCorner<3, 3>();
  const PlanarPose there = compose(found.map_from_track, body);
  return found.map == map_ && (there.p - body.p).norm() <= kMostSigmas * sigma_m() &&
         std::abs(std::remainder(there.yaw - body.yaw, 2 * M_PI)) <=
             kCrossing + kMostSigmas * std::sqrt(covariance(2, 2));
}

// How the ground has changed is not told with a place. So the change that fits best near there is
// supposed, again and again, until the place is proved.
void Mapper::suppose_change() {
  const gpr::TraceMemory& memory = ground_.memory;
  if (!memory.can_undo() || path_.travelled() < candidate_->next_change_m) return;
  candidate_->next_change_m = path_.travelled() + kSupposeEvery;
  const Hypothesis& at = candidate_->at;
  const PlanarPose here = compose(at.map_from_track, newest_node_.pose);
  const double gate = std::min(kGateSigmas * sigma_m(), kGateMax);
  const auto best = Locator::change_near(ground_, end_of_before_, {at.map, here.p, gate});
  const gpr::TraceChange& now = change_.change();
  if (!best || (best->stretch == now.stretch && best->turn == now.turn)) return;
  change_.believe(*best);
  forget_searches();
}

// A place that was found is the best of a great many, and a drive over other ground tries many such
// places. So one revisit does not prove it: it needs another one whose patch has none of the
// ground of the first.
bool Mapper::is_proved() {
  if (candidate_->told_sigma_m > 0.0) return true;
  const double travelled = path_.travelled();
  if (!candidate_->supported_m) {
    candidate_->supported_m = travelled;
    candidate_->until_m = travelled + kAgainWithin;
  }
  return travelled - *candidate_->supported_m >= config_.patch_length;
}

// The track is located: from now on `map` is the frame of the earlier ground.
void Mapper::join_map(const Hypothesis& at) {
  if (tied_) {  // to site, and so is the ground now
    move_ground(at.map, between(at.map_from_track, {}));
  } else {
    graph_->move(at.map_from_track);
    move_newest(at.map_from_track);
  }
  map_ = at.map;
  moved_ = located_ = true;
  next_solve_ = 0;
}

}  // namespace gprodom
