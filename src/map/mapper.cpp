#include "map/mapper.h"

#include <algorithm>
#include <utility>

#include "estimation/graph/slip_model.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

// Squared correlation, the share of the variance that the stored ground explains. Below a half most
// of the ground is new, as 20 cm aside.
constexpr double kAlike = 0.5;

}  // namespace

Mapper::Mapper(const Config& config, std::optional<GroundMap> before,
               std::optional<TrackStart> start)
    : config_(config.graph),
      starts_in_(start ? std::optional(start->map) : std::nullopt),
      track_(slip_model(config.wheel), std::move(start)),
      store_(config, std::move(before)),
      site_(config.anchor, track_, store_),
      relocation_(config_, track_, store_),
      search_(config_, track_, store_, relocation_) {}

// The whole algorithm, for what has come since the last job.
MapAnswer Mapper::run(const MapInput& input) {
  MapAnswer answer;
  const bool was_located = store_.located();
  track_.follow(input.states);  // the path, and a node of the graph every kNodeSpacing
  if (!track_.begun()) return answer;
  if (const auto map = std::exchange(starts_in_, std::nullopt)) store_.locate_in(*map, true);
  if (const auto errors = track_.errors(input.scale_sigma)) store_.note_errors(*errors);
  external_.insert(external_.end(), input.revisits.begin(), input.revisits.end());
  use_external(answer);                           // revisits of other processes
  answer.tied = site_.take(input, answer.notes);  // fixes, and whether map is site now
  if (input.told && relocation_.suppose(*input.told, answer.notes)) search_.forget();
  const auto take = [&](const GroundSearch::Found& found) { use_found(found, answer); };
  for (const GprTrace& trace : input.traces) {
    if (store_.remember(trace, track_.path(), answer.notes)) search_.follow_antenna();
    search_.look(take);  // revisits on ground nearby become edges of the graph
  }
  for (const GprTrace& trace : input.beside) search_.look_beside(trace, take);
  if (relocation_.locate(answer.notes)) search_.forget();  // on all ground, where that is due
  answer.located = store_.located() && !was_located;
  answer.map = store_.map();
  const auto has_ground = [this](std::size_t node) {
    return store_.column_at(track_.path(), node).has_value();
  };
  if (track_.solve_if_due({input.scale, input.scale_sigma}, has_ground, answer.notes))
    site_.place_fixes();
  answer.fixes = site_.report();
  answer.pose = track_.pose();
  answer.travelled_m = track_.path().travelled();
  answer.sigma_m = relocation_.sigma_m();
  return answer;
}

void Mapper::use_external(MapAnswer& answer) {
  const MapPath& path = track_.path();
  while (!external_.empty() && external_.front().to <= path.newest().time) {
    const Displacement told = external_.front();
    external_.pop_front();
    const MapPath::Place memory = path.place(told.from), query = path.place(told.to);
    RevisitEdge edge;
    edge.offset_m = told.distance_m;
    edge.sigma_m = std::max(kLeastRevisitSigma, told.sigma_m);
    edge.lateral_m = told.lateral_m;
    edge.lateral_sigma_m = told.lateral_sigma_m > 0 ? told.lateral_sigma_m : config_.lateral_sigma;
    edge.mirrored = told.mirrored == (memory.direction == query.direction);
    const PlanarPose antenna = store_.default_antenna();
    if (told.from < path.time_of(0)) {
      answer.notes.emplace_back("a revisit of another process begins before the track: not used");
    } else if (path.is_forgotten(told.from)) {
      answer.notes.emplace_back(
          "a revisit of another process begins on a pass that the map has merged with an "
          "earlier one: not used");
    } else if (!track_.add_revisit(track_.end_at(memory, antenna), track_.end_at(query, antenna),
                                   edge)) {
      answer.notes.emplace_back("a revisit of another process contradicts the headings: not used");
    }
  }
}

void Mapper::use_found(const GroundSearch::Found& found, MapAnswer& answer) {
  const auto memory = store_.end_at(found.place.column, track_);
  if (!memory) return;
  const Sighting seen = sighting(found, *memory);
  if (relocation_.speaks_for_candidate(*memory, found.query)) {
    auto proved = relocation_.support(seen);
    if (!proved) return;
    join(std::move(*proved), answer);
  } else if (!use(seen, answer)) {
    return;
  }
  const double correlation = found.place.match.correlation;
  if (!found.seeker.beside && correlation * correlation > kAlike)
    store_.mark_known(found.query, track_.path().travelled());
}

Sighting Mapper::sighting(const GroundSearch::Found& found, const RevisitEnd& memory) const {
  const gpr::RevisitMatch& match = found.place.match;
  const gpr::MemoryColumn& query = found.query;
  const gpr::MemoryColumn then =
      store_.memory().column(static_cast<std::size_t>(found.place.column));
  Sighting seen{memory,
                found.place.column,
                query,
                found.seeker.antenna,
                edge_of(match, found.moved_m, config_),
                {}};
  // The memory has the direction of driving, the edge the heading. They differ when driving
  // backwards.
  seen.edge.mirrored = match.mirrored == (then.direction == query.direction);
  // 0: the earlier pass belongs to another track
  seen.told.from = memory.node == kInMap ? 0 : then.time;
  seen.told.to = query.time;
  seen.told.source = "revisit";
  seen.told.kind = DisplacementKind::kRevisit;
  seen.told.valid = true;
  seen.told.sigma_m = seen.edge.sigma_m;
  seen.told.lateral_sigma_m = seen.edge.lateral_sigma_m;
  seen.told.mirrored = match.mirrored;
  seen.told.scale = match.scale;
  seen.told.score = match.score;
  return seen;
}

// A revisit as an edge of the graph. Returns false where it contradicts the graph.
bool Mapper::use(const Sighting& seen, MapAnswer& answer) {
  const MapPath::Place place = track_.path().place(seen.query.time, seen.query.distance_m);
  if (!track_.add_revisit(seen.memory, track_.end_at(place, seen.antenna), seen.edge)) return false;
  answer.revisits.push_back(seen.told);
  return true;
}

// The revisits of a candidate that is proved are used, now that it is known where the track lies. A
// track that was lost is in the map already: what they say corrects it.
void Mapper::join(Relocation::Candidate proved, MapAnswer& answer) {
  track_.solve_soon();
  const bool first = !proved.at.own && !store_.located();
  if (first && track_.in_site()) {
    const PlanarPose by = between(proved.at.map_from_track, {});
    for (Sighting& one : proved.supporting) {
      one.memory.body = compose(by, one.memory.body);
      one.memory.yaw = one.memory.body.yaw;
    }
  }
  if (first) join_map(proved.at);
  for (Sighting& one : proved.supporting) {
    if (proved.at.own) {
      const std::optional<RevisitEnd> memory = store_.end_at(one.column, track_);
      if (!memory) continue;
      one.memory = *memory;
    }
    use(one, answer);
  }
}

// The track is located: from now on `map` is the frame of the earlier ground. If the track is tied
// to site, so is the ground now.
void Mapper::join_map(const Hypothesis& at) {
  if (track_.in_site())
    store_.move_places(at.map, between(at.map_from_track, {}));
  else
    track_.move(at.map_from_track);
  store_.locate_in(at.map);
}

SavedGround Mapper::saved_ground(bool main) {
  site_.note_datum();
  return store_.saved(track_, main);
}

SavedGround Mapper::newest_ground() {
  site_.note_datum();
  return store_.newest(track_);
}

GroundMap Mapper::take_ground() {
  site_.note_datum();
  return store_.take(track_);
}

GroundMap Mapper::take_earlier_ground() {
  site_.note_datum();
  return store_.take_earlier(track_);
}

}  // namespace gprodom
