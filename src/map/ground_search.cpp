#include "map/ground_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "map/crowded_ground.h"
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

GroundSearch::GroundSearch(const GraphConfig& config, const TrackGraph& track, GroundStore& store,
                           Relocation& relocation)
    : config_(config), track_(track), store_(store), relocation_(relocation) {
  seeker_.antenna = store.antenna();
}

void GroundSearch::follow_antenna() {
  seeker_.antenna = store_.antenna();
  seeker_.last_query.reset();
  forget();
}

void GroundSearch::forget() {
  seeker_.forget();
  for (auto& [id, seeker] : abreast_) seeker.forget();
}

void GroundSearch::look_beside(const GprTrace& trace, const Take& take) {
  const std::optional<PlanarPose> antenna = store_.antenna(trace.antenna_id);
  if (!antenna || !store_.memory().filter() ||
      !same_format(store_.ground().format, format_of(trace)))
    return;
  Seeker& seeker = abreast_[trace.antenna_id];
  if (!seeker.beside) {
    seeker.antenna = *antenna;
    seeker.beside = store_.memory().beside();
  }
  seeker.beside->add(trace.time, trace.samples, trace.sample_interval_s,
                     track_.path().distance_at(trace.time));
  search(seeker, take);
}

void GroundSearch::search(Seeker& seeker, const Take& take) {
  const gpr::TraceMemory& newest = newest_of(seeker);
  if (!newest.filter()) return;
  if (!seeker.search) begin(seeker);
  const auto place = newest.newest_place(seeker.search->patch_columns());
  if (!place) return;
  double moved_m = config_.patch_length;
  if (seeker.last_query && seeker.last_query->direction == place->direction) {
    moved_m = std::abs(place->distance_m - seeker.last_query->distance_m);
    if (moved_m < kQuerySpacing) return;
  } else {
    seeker.forget();
  }
  std::vector<gpr::SearchWindow> near = windows(seeker, *place);
  if (crowded_ && !seeker.beside) store_.mark_known(*place, track_.path().travelled());
  seeker.last_query = place;
  const auto own = std::stable_partition(near.begin(), near.end(), [&](const auto& window) {
    return seeker.search_before && window.run < store_.end_of_before();
  });
  const std::vector<gpr::SearchWindow> before(near.begin(), own);
  near.erase(near.begin(), own);
  find_in(seeker, false, moved_m, near, take);
  if (seeker.search_before) find_in(seeker, true, moved_m, before, take);
}

void GroundSearch::begin(Seeker& seeker) const {
  const gpr::TraceMemory& memory = store_.memory();
  seeker.search.emplace(*memory.filter(), memory.spacing(), search_options(config_, false));
  if (!memory.can_undo()) return;
  seeker.search_before.emplace(*memory.filter(), memory.spacing(), search_options(config_, true));
}

// before: in ground of earlier tracks.
void GroundSearch::find_in(Seeker& seeker, bool before, double moved_m,
                           const std::vector<gpr::SearchWindow>& windows, const Take& take) {
  gpr::RevisitSearch& search = before ? *seeker.search_before : *seeker.search;
  if (windows.empty()) {
    search.forget();
    return;
  }
  const gpr::TraceChange change = before ? relocation_.change().change() : gpr::TraceChange{};
  const auto newest = *newest_of(seeker).newest(search.patch_columns(), kBefore, change);
  const std::vector<gpr::PlaceFound> found = search.find(newest.features, moved_m, windows);
  for (const gpr::PlaceFound& place : found) take({seeker, place, newest.centre, moved_m});
  if (found.empty() || !before || seeker.beside) return;
  const gpr::TraceMemory& memory = store_.memory();
  relocation_.change().follow(memory, found.front().column, [&](const gpr::TraceChange& tried) {
    return memory.newest(search.patch_columns(), 0, tried)->features;
  });
}

// The passes of this track near `here`, an antenna's pose. The query begins `query_begins` m along
// the track.
std::vector<Pass> GroundSearch::own_passes(const PlanarPose& here, const Reach& reach,
                                           double query_begins,
                                           const gpr::MemoryColumn& query) const {
  const MapPath& path = track_.path();
  PassFinder finder(here, reach.gate_m + kNodeSpacing, reach.aside_m, store_.longest_arm_m());
  for (std::size_t node = 0; node < path.nodes() && path.travelled_at(node) < query_begins;
       ++node) {
    if (path.begins_piece(node)) finder.interrupt();
    const PlanarPose& body = track_.graph().nodes()[node];
    if (finder.may_be_near(body))
      finder.offer(node, compose(body, store_.antenna_at(path, node)), false);
  }
  std::vector<Pass> passes = finder.passes();
  // Ground just before the query that was driven in the same direction would be found as itself.
  const auto is_useless = [&](const Pass& pass) {
    const auto column = store_.column_at(path, pass.place);
    if (!column) return true;  // forgotten
    if (path.travelled_at(pass.place) < query_begins - reach.gate_m) return false;
    return !is_mirrored(pass, store_.memory().column(*column), query);
  };
  passes.erase(std::remove_if(passes.begin(), passes.end(), is_useless), passes.end());
  return passes;
}

// The passes of earlier tracks near an antenna's pose in one of their maps.
std::vector<Pass> GroundSearch::passes_of_before(const PlanarPose& here, int map,
                                                 const Reach& reach, const Seeker& seeker) const {
  PassFinder finder(here, reach.gate_m + kNodeSpacing, reach.aside_m, store_.longest_arm_m());
  const GroundMap& ground = store_.ground();
  for (std::size_t i = 0; i < ground.places.size(); ++i) {
    const KnownPlace& place = ground.places[i];
    if (place.map == map && finder.may_be_near(place.pose))
      finder.offer(i, compose(place.pose, ground.antenna_at(place.column, seeker.antenna)), true);
  }
  std::vector<Pass> passes = finder.passes();
  const auto is_forgotten = [&](const Pass& pass) {
    return ground.places[pass.place].column < ground.memory.kept().first;
  };
  passes.erase(std::remove_if(passes.begin(), passes.end(), is_forgotten), passes.end());
  return passes;
}

// The stretches of stored ground on which, by the poses, the query may lie. Those with the smallest
// lateral offset come first. Notes whether so many passes lie side by side that one more would lie
// within an antenna's footprint of another.
std::vector<gpr::SearchWindow> GroundSearch::windows(const Seeker& seeker,
                                                     const gpr::MemoryColumn& query) {
  const MapPath::Place at = track_.path().place(query.time, query.distance_m);
  const PlanarPose here = compose(track_.body_at(at), seeker.antenna);
  const double sigma = relocation_.sigma_m();
  const std::optional<Relocation::Candidate>& candidate = relocation_.candidate();
  const double gate = std::clamp(kGateSigmas * sigma, kGateMin, kGateMax);
  const Reach reach{gate, kLateralGate + std::min(kGateSigmas * sigma, kGateMax)};
  const double query_begins = track_.path().travelled_at(at.node) - config_.patch_length;

  std::vector<Pass> passes, supposed;
  if (candidate) {
    const PlanarPose there = compose(candidate->at.map_from_track, here);
    supposed = candidate->at.own ? own_passes(there, reach, query_begins, query)
                                 : passes_of_before(there, candidate->at.map, reach, seeker);
  }
  if (store_.located() && (!candidate || candidate->at.own))
    passes = passes_of_before(here, store_.map(), reach, seeker);
  for (const Pass& pass : own_passes(here, reach, query_begins, query)) passes.push_back(pass);
  crowded_ = track_.tied_at_m() &&
             track_.path().travelled() - *track_.tied_at_m() < kKnowsPassesFor &&
             is_crowded(passes, config_.lateral_sigma);
  std::vector<gpr::SearchWindow> windows;
  for (const Pass& pass : in_search_order(std::move(supposed), config_.lateral_sigma)) {
    if (windows.size() < kMaxWindows) windows.push_back(window_at(seeker, pass, query, gate));
  }
  const std::vector<gpr::SearchWindow> of_candidate = windows;
  // A hypothesis on own ground, of which several may be wrong, takes nothing from the search here.
  const std::size_t most = kMaxWindows + (candidate && candidate->at.own ? windows.size() : 0);
  for (const Pass& pass : in_search_order(std::move(passes), config_.lateral_sigma)) {
    if (windows.size() == most) break;
    gpr::SearchWindow window = window_at(seeker, pass, query, gate);
    const bool is_searched =
        std::any_of(of_candidate.begin(), of_candidate.end(), [&](const auto& other) {
          const double apart = std::abs(other.expected - window.expected);
          return other.run == window.run &&
                 apart * store_.memory().spacing() < other.bound_m + window.bound_m;
        });
    if (!is_searched) windows.push_back(std::move(window));
  }
  return windows;
}

gpr::SearchWindow GroundSearch::window_at(const Seeker& seeker, const Pass& pass,
                                          const gpr::MemoryColumn& query, double gate) const {
  const gpr::TraceMemory& memory = store_.memory();
  const std::size_t column = pass.from_before ? store_.ground().places[pass.place].column
                                              : *store_.column_at(track_.path(), pass.place);
  const double distance = pass.from_before ? store_.ground().places[pass.place].distance_m
                                           : track_.path().distance_of(pass.place);
  // Distances in the memory are those of the odometry.
  const double longer = pass.from_before ? 1.0 : std::exp(-track_.graph().slip(pass.place));
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
void GroundSearch::predict_stretch(const Seeker& seeker, const Pass& pass,
                                   const gpr::MemoryColumn& query,
                                   gpr::SearchWindow& window) const {
  const std::size_t here = track_.path().place(query.time, query.distance_m).node;
  const double slip_then = pass.from_before ? 0.0 : track_.graph().slip(pass.place);
  const double sigma_now = track_.graph().slip_sigma(here);
  // The slip of an earlier track is not known; its variance is taken to be that of this one.
  const double sigma_then = pass.from_before ? sigma_now : track_.graph().slip_sigma(pass.place);
  window.grip =
      (1.0 - track_.slip().probability(sigma_now)) * (1.0 - track_.slip().probability(sigma_then));
  window.stretch = track_.graph().slip(here) - slip_then;
  window.stretch_sigma = std::hypot(std::sqrt(track_.newest_node().covariance(4, 4)), sigma_then);
  if (window.grip < 1.0) window.stretch_sigma /= std::sqrt(1.0 - window.grip);
  // Both slips may begin, end or change, the one now and the one then.
  const double seconds =
      seeker.last_query ? 2.0 * to_seconds(query.time - seeker.last_query->time) : 0.0;
  window.kept = track_.slip().correlation(seconds);
  window.stretch_change = track_.slip().change * std::sqrt(seconds);
}

}  // namespace gprodom
