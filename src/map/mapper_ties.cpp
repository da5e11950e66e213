// Mapper: revisits as edges of the pose graph, its own and those of other processes.
#include <algorithm>
#include <cmath>
#include <utility>

#include "map/mapper.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

// Squared correlation, the share of the variance that the stored ground explains. Below a half most
// of the ground is new, as 20 cm aside.
constexpr double kAlike = 0.5;
constexpr double kLocatedWithin = 200.0;  // m driven, then known ground is no longer stored twice

}  // namespace

Mapper::End Mapper::end_at(const MapPath::Place& place, const PlanarPose& antenna) const {
  return {place.node, place.at, graph_->nodes()[place.node].yaw, place.way, antenna};
}

std::optional<Mapper::End> Mapper::remembered_end(double column) const {
  const auto number = static_cast<std::size_t>(column);
  if (number < end_of_before_) {
    const auto then = ground_.at(column, 2 * kNodeSpacing);
    if (!then) return std::nullopt;
    return End{kInMap, then->pose, then->pose.yaw, {}, ground_.antenna_at(number, seeker_.antenna)};
  }
  const gpr::MemoryColumn then = ground_.memory.column(number);
  const double beyond = (column - static_cast<double>(number)) * ground_.memory.spacing();
  return end_at(path_.place(then.time, then.distance_m + then.direction * beyond),
                ground_.antenna_at(number, seeker_.antenna));
}

// Returns false if both ends lie at the same node, or if the headings contradict the direction.
bool Mapper::add_edge(const End& memory, const End& query, RevisitEdge edge) {
  const bool turned = std::cos(query.yaw - memory.yaw) < 0.0;
  if (memory.node == query.node || turned != edge.mirrored) return false;
  edge.memory = memory.node;
  edge.query = query.node;
  edge.memory_at = compose(memory.body, memory.antenna);
  edge.query_at = compose(query.body, query.antenna);
  edge.memory_way = memory.way;
  edge.query_way = query.way;
  graph_->add_revisit(edge);
  return true;
}

// A revisit as an edge of the graph. Returns false where it contradicts the graph.
bool Mapper::use(const Sighting& seen, MapAnswer& answer) {
  const End query = end_at(path_.place(seen.query.time, seen.query.distance_m), seen.antenna);
  if (!add_edge(seen.memory, query, seen.edge)) return false;
  answer.revisits.push_back(seen.told);
  return true;
}

Mapper::Sighting Mapper::sighting(const Seeker& seeker, const End& memory,
                                  const gpr::MemoryColumn& then, const gpr::MemoryColumn& query,
                                  const gpr::RevisitMatch& match, double moved_m) const {
  Sighting seen{memory, 0.0, query, seeker.antenna, edge_of(match, moved_m, config_), {}};
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

// A revisit of the candidate joins the track to the map if it proves it; until then it waits. A
// track that was lost is in the map already: what the revisits say corrects it.
bool Mapper::support(const Sighting& seen, MapAnswer& answer) {
  const MapPath::Place query = path_.place(seen.query.time, seen.query.distance_m);
  const double yaw = end_at(query, seen.antenna).yaw + candidate_->at.map_from_track.yaw;
  if ((std::cos(yaw - seen.memory.yaw) < 0.0) != seen.edge.mirrored) return false;
  candidate_->supporting.push_back(seen);
  if (!is_proved()) return false;
  Candidate proved = *std::exchange(candidate_, std::nullopt);
  next_solve_ = 0;
  if (proved.at.own) {
    for (Sighting& one : proved.supporting) {
      const std::optional<End> memory = remembered_end(one.column);
      if (!memory) continue;
      one.memory = *memory;
      use(one, answer);
    }
    return true;
  }
  if (tied_ && !located_) {
    const PlanarPose by = between(proved.at.map_from_track, {});
    for (Sighting& one : proved.supporting) one.memory.body = compose(by, one.memory.body);
    for (Sighting& one : proved.supporting) one.memory.yaw = one.memory.body.yaw;
  }
  if (!located_) join_map(proved.at);
  for (const Sighting& one : proved.supporting) use(one, answer);
  return true;
}

// Whether a revisit speaks for the candidate. On own ground: if it is nearer to where the candidate
// has the robot than to where the track has it.
bool Mapper::is_of_candidate(const End& memory, const gpr::MemoryColumn& query) const {
  if (!candidate_->at.own) return memory.node == kInMap;
  if (memory.node == kInMap) return false;
  const Eigen::Vector2d then = graph_->place(memory.node, memory.body, memory.way).p;
  const PlanarPose here = body_at(path_.place(query.time, query.distance_m));
  const PlanarPose there = compose(candidate_->at.map_from_track, here);
  return (then - there.p).norm() < (then - here.p).norm();
}

void Mapper::tie(const Seeker& seeker, const gpr::PlaceFound& found, const gpr::MemoryColumn& query,
                 double moved_m, MapAnswer& answer) {
  const gpr::MemoryColumn then = ground_.memory.column(static_cast<std::size_t>(found.column));
  const auto memory_end = remembered_end(found.column);
  if (!memory_end) return;
  Sighting seen = sighting(seeker, *memory_end, then, query, found.match, moved_m);
  seen.column = found.column;
  const bool joins = candidate_ && is_of_candidate(*memory_end, query);
  if (!(joins ? support(seen, answer) : use(seen, answer))) return;
  if (!seeker.beside && found.match.correlation * found.match.correlation > kAlike)
    mark_known(query);
}

// The ground of a query is not stored once more. But a track that is not located yet keeps all its
// ground, since the search in earlier ground needs it whole.
void Mapper::mark_known(const gpr::MemoryColumn& query) {
  if (!located_ && end_of_before_ > 0 && path_.travelled() <= kLocatedWithin) return;
  const double half = 0.5 * config_.patch_length;
  ground_.memory.mark_known(query.distance_m - half, query.distance_m + half);
}

void Mapper::take_external(MapAnswer& answer) {
  const PlanarPose antenna{lever_arm_.head<2>(), 0.0};
  while (!external_.empty() && external_.front().to <= path_.newest().time) {
    const Displacement told = external_.front();
    external_.pop_front();
    const MapPath::Place memory = path_.place(told.from), query = path_.place(told.to);
    RevisitEdge edge;
    edge.offset_m = told.distance_m;
    edge.sigma_m = std::max(kLeastRevisitSigma, told.sigma_m);
    edge.lateral_m = told.lateral_m;
    edge.lateral_sigma_m = told.lateral_sigma_m > 0 ? told.lateral_sigma_m : config_.lateral_sigma;
    edge.mirrored = told.mirrored == (memory.direction == query.direction);
    if (told.from < path_.time_of(0)) {
      answer.notes.push_back("a revisit of another process begins before the track: not used");
    } else if (path_.is_forgotten(told.from)) {
      answer.notes.push_back(
          "a revisit of another process begins on a pass that the map has merged with an "
          "earlier one: not used");
    } else if (!add_edge(end_at(memory, antenna), end_at(query, antenna), edge)) {
      answer.notes.push_back("a revisit of another process contradicts the headings: not used");
    }
  }
}

}  // namespace gprodom
