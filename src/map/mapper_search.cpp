// Mapper: the search of the memory for the newest ground, and the windows of it that are searched.
#include <algorithm>
#include <cmath>
#include <utility>

#include "map/crowded_ground.h"
#include "map/mapper.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

constexpr std::size_t kMaxWindows = 2;  // passes over a place that are searched
// m driven since the last trusted revisit, on which odometry with an error of 1 % stays within
// kLateralGate. Beyond, the poses do not tell which passes lie beside the robot.
constexpr double kKnowsPassesFor = 100.0 * kLateralGate;

// Whether the ground is driven against the memory's direction. The memory has the direction of
// driving, the poses have the heading.
bool is_mirrored(const Pass& pass, const gpr::MemoryColumn& then, const gpr::MemoryColumn& query) {
  return pass.turned != (then.direction != query.direction);
}

}  // namespace

// The newest ground of an antenna abreast of the one whose ground is stored.
void Mapper::look_beside(const GprTrace& trace, MapAnswer& answer) {
  const auto place = antennas_.find(trace.antenna_id);
  if (place == antennas_.end() || !ground_.memory.filter() ||
      !same_format(ground_.format, format_of(trace)))
    return;
  Seeker& seeker = abreast_[trace.antenna_id];
  if (!seeker.beside) {
    seeker.antenna = {place->second.head<2>(), 0.0};
    seeker.beside = ground_.memory.beside();
  }
  seeker.beside->add(trace.time, trace.samples, trace.sample_interval_s,
                     path_.distance_at(trace.time));
  search_memory(seeker, answer);
}

// Every kQuerySpacing, searches the memory for the newest ground.
void Mapper::search_memory(Seeker& seeker, MapAnswer& answer) {
  const gpr::TraceMemory& newest = newest_of(seeker);
  if (!newest.filter()) return;
  if (!seeker.search) begin_searches(seeker);
  const auto place = newest.newest_place(seeker.search->patch_columns());
  if (!place) return;
  double moved = config_.patch_length;
  if (seeker.last_query && seeker.last_query->direction == place->direction) {
    moved = std::abs(place->distance_m - seeker.last_query->distance_m);
    if (moved < kQuerySpacing) return;
  } else {
    seeker.forget();
  }
  std::vector<gpr::SearchWindow> near = windows(seeker, *place);
  if (crowded_ && !seeker.beside) mark_known(*place);
  seeker.last_query = place;
  const auto own = std::stable_partition(near.begin(), near.end(), [&](const auto& window) {
    return seeker.search_before && window.run < end_of_before_;
  });
  const std::vector<gpr::SearchWindow> before(near.begin(), own);
  near.erase(near.begin(), own);
  find_in(seeker, false, moved, near, answer);
  if (seeker.search_before) find_in(seeker, true, moved, before, answer);
}

void Mapper::begin_searches(Seeker& seeker) const {
  const gpr::TraceMemory& memory = ground_.memory;
  seeker.search.emplace(*memory.filter(), memory.spacing(), search_options(config_, false));
  if (!memory.can_undo()) return;
  seeker.search_before.emplace(*memory.filter(), memory.spacing(), search_options(config_, true));
}

void Mapper::forget_searches() {
  seeker_.forget();
  for (auto& [id, seeker] : abreast_) seeker.forget();
}

// before: in ground of earlier tracks.
void Mapper::find_in(Seeker& seeker, bool before, double moved,
                     const std::vector<gpr::SearchWindow>& windows, MapAnswer& answer) {
  gpr::RevisitSearch& search = before ? *seeker.search_before : *seeker.search;
  if (windows.empty()) {
    search.forget();
    return;
  }
  const gpr::TraceChange change = before ? change_.change() : gpr::TraceChange{};
  const auto newest = *newest_of(seeker).newest(search.patch_columns(), kBefore, change);
  const std::vector<gpr::PlaceFound> found = search.find(newest.features, moved, windows);
  for (const gpr::PlaceFound& place : found) tie(seeker, place, newest.centre, moved, answer);
  if (found.empty() || !before || seeker.beside) return;
  change_.follow(ground_.memory, found.front().column, [&](const gpr::TraceChange& tried) {
    return ground_.memory.newest(search.patch_columns(), 0, tried)->features;
  });
}

// The passes of this track near `here`, an antenna's pose. The query begins `query_begins` m along
// the track.
std::vector<Pass> Mapper::own_passes(const PlanarPose& here, const Reach& reach,
                                     double query_begins, const gpr::MemoryColumn& query) const {
  PassFinder finder(here, reach.gate_m + kNodeSpacing, reach.aside_m, longest_arm_m_);
  for (std::size_t node = 0; node < path_.nodes() && path_.travelled_at(node) < query_begins;
       ++node) {
    if (path_.begins_piece(node)) finder.interrupt();
    const PlanarPose& body = graph_->nodes()[node];
    if (finder.may_be_near(body)) finder.offer(node, compose(body, antenna_at(node)), false);
  }
  std::vector<Pass> passes = finder.passes();
  // Ground just before the query that was driven in the same direction would be found as itself.
  const auto is_useless = [&](const Pass& pass) {
    if (!column_at(pass.place)) return true;  // forgotten
    if (path_.travelled_at(pass.place) < query_begins - reach.gate_m) return false;
    return !is_mirrored(pass, ground_.memory.column(*column_at(pass.place)), query);
  };
  passes.erase(std::remove_if(passes.begin(), passes.end(), is_useless), passes.end());
  return passes;
}

// The passes of earlier tracks near an antenna's pose in one of their maps.
std::vector<Pass> Mapper::passes_of_before(const PlanarPose& here, int map, const Reach& reach,
                                           const Seeker& seeker) const {
  PassFinder finder(here, reach.gate_m + kNodeSpacing, reach.aside_m, longest_arm_m_);
  for (std::size_t i = 0; i < ground_.places.size(); ++i) {
    const KnownPlace& place = ground_.places[i];
    if (place.map == map && finder.may_be_near(place.pose))
      finder.offer(i, compose(place.pose, ground_.antenna_at(place.column, seeker.antenna)), true);
  }
  std::vector<Pass> passes = finder.passes();
  const auto is_forgotten = [&](const Pass& pass) {
    return ground_.places[pass.place].column < ground_.memory.kept().first;
  };
  passes.erase(std::remove_if(passes.begin(), passes.end(), is_forgotten), passes.end());
  return passes;
}

// The stretches of stored ground on which, by the poses, the query may lie. Those with the smallest
// lateral offset come first. Notes whether so many passes lie side by side that one more would lie
// within an antenna's footprint of another.
std::vector<gpr::SearchWindow> Mapper::windows(const Seeker& seeker,
                                               const gpr::MemoryColumn& query) {
  const MapPath::Place at = path_.place(query.time, query.distance_m);
  const PlanarPose here = compose(body_at(at), seeker.antenna);
  const double sigma = sigma_m();
  const double gate = std::clamp(kGateSigmas * sigma, kGateMin, kGateMax);
  const Reach reach{gate, kLateralGate + std::min(kGateSigmas * sigma, kGateMax)};
  const double query_begins = path_.travelled_at(at.node) - config_.patch_length;

  std::vector<Pass> passes, supposed;
  if (candidate_) {
    const PlanarPose there = compose(candidate_->at.map_from_track, here);
    supposed = candidate_->at.own ? own_passes(there, reach, query_begins, query)
                                  : passes_of_before(there, candidate_->at.map, reach, seeker);
  }
  if (located_ && (!candidate_ || candidate_->at.own))
    passes = passes_of_before(here, map_, reach, seeker);
  for (const Pass& pass : own_passes(here, reach, query_begins, query)) passes.push_back(pass);
  crowded_ = tied_at_m_ && path_.travelled() - *tied_at_m_ < kKnowsPassesFor &&
             is_crowded(passes, config_.lateral_sigma);
  std::vector<gpr::SearchWindow> windows;
  for (const Pass& pass : in_search_order(std::move(supposed), config_.lateral_sigma)) {
    if (windows.size() < kMaxWindows) windows.push_back(window_at(seeker, pass, query, gate));
  }
  const std::vector<gpr::SearchWindow> of_candidate = windows;
  // A hypothesis on own ground, of which several may be wrong, takes nothing from the search here.
  const std::size_t most = kMaxWindows + (candidate_ && candidate_->at.own ? windows.size() : 0);
  for (const Pass& pass : in_search_order(std::move(passes), config_.lateral_sigma)) {
    if (windows.size() == most) break;
    gpr::SearchWindow window = window_at(seeker, pass, query, gate);
    const bool is_searched =
        std::any_of(of_candidate.begin(), of_candidate.end(), [&](const auto& other) {
          const double apart = std::abs(other.expected - window.expected);
          return other.run == window.run &&
                 apart * ground_.memory.spacing() < other.bound_m + window.bound_m;
        });
    if (!is_searched) windows.push_back(std::move(window));
  }
  return windows;
}

PlanarPose Mapper::body_at(const MapPath::Place& place) const {
  return graph_->place(place.node, place.at, place.way);
}

// In body: the one that saw the ground there.
PlanarPose Mapper::antenna_at(std::size_t node) const {
  const auto column = column_at(node);
  return column ? ground_.antenna_at(*column, seeker_.antenna) : seeker_.antenna;
}

gpr::SearchWindow Mapper::window_at(const Seeker& seeker, const Pass& pass,
                                    const gpr::MemoryColumn& query, double gate) const {
  const gpr::TraceMemory& memory = ground_.memory;
  const std::size_t column =
      pass.from_before ? ground_.places[pass.place].column : *column_at(pass.place);
  const double distance =
      pass.from_before ? ground_.places[pass.place].distance_m : path_.distance_of(pass.place);
  // Distances in the memory are those of the odometry.
  const double longer = pass.from_before ? 1.0 : std::exp(-graph_->slip(pass.place));
  const gpr::MemoryColumn then = memory.column(column);
  const double ahead = distance + longer * pass.along - then.distance_m;
  gpr::SearchWindow window =
      window_on(memory, column, ahead, longer * gate, seeker.search->reach_m());
  predict_stretch(seeker, pass, query, window);
  window.mirrored = is_mirrored(pass, then, query);
  return window;
}

// The stretch that the graph's estimates of the slip there and here let expect. The slip there gets
// its prior variance: the posterior is correlated with other passes through the revisits.
void Mapper::predict_stretch(const Seeker& seeker, const Pass& pass, const gpr::MemoryColumn& query,
                             gpr::SearchWindow& window) const {
  const std::size_t here = path_.place(query.time, query.distance_m).node;
  const double slip_then = pass.from_before ? 0.0 : graph_->slip(pass.place);
  const double sigma_now = graph_->slip_sigma(here);
  // The slip of an earlier track is not known; its variance is taken to be that of this one.
  const double sigma_then = pass.from_before ? sigma_now : graph_->slip_sigma(pass.place);
  window.grip = (1.0 - slip_.probability(sigma_now)) * (1.0 - slip_.probability(sigma_then));
  window.stretch = graph_->slip(here) - slip_then;
  window.stretch_sigma = std::hypot(std::sqrt(newest_node_.covariance(4, 4)), sigma_then);
  if (window.grip < 1.0) window.stretch_sigma /= std::sqrt(1.0 - window.grip);
  // Both slips may begin, end or change, the one now and the one then.
  const double seconds =
      seeker.last_query ? 2.0 * to_seconds(query.time - seeker.last_query->time) : 0.0;
  window.kept = slip_.correlation(seconds);
  window.stretch_change = slip_.change * std::sqrt(seconds);
}

}  // namespace gprodom
