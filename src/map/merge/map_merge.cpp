#include "map/merge/map_merge.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "map/path/map_path.h"

namespace gprodom {
namespace {

using gpr::MemoryRange;

void check(const GroundMap& first, const GroundMap& second) {
  for (const GroundMap* ground : {&first, &second}) {
    if (ground->version == 1)
      throw std::invalid_argument(
          "a file of version 1 holds features alone: it can be driven on, but not merged");
    if (ground->places.empty()) throw std::invalid_argument("a file holds no ground");
  }
  const bool same = same_format(first.format, second.format) &&
                    first.memory.sessions()[0].step == second.memory.sessions()[0].step;
  if (!same)
    throw std::invalid_argument(
        "the traces of the two files differ in length, interval or band: another type of radar");
  const double metres =
      static_cast<double>(first.memory.kept().size() + second.memory.kept().size()) *
      first.memory.spacing();
  const double most = first.memory.options().max_length_m;
  if (metres > most)
    throw std::invalid_argument("together they are longer than a map can be (" +
                                std::to_string(std::lround(most)) + " m): cut one of them first");
}

// All of both. Nothing relates their maps yet.
GroundMap both_of(const GroundMap& first, const GroundMap& second) {
  GroundMap both(first.memory.options());
  both.format = first.format;
  std::vector<gpr::BandLimit> sessions;
  std::vector<gpr::StoredRun> runs;
  for (const GroundMap* ground : {&first, &second}) {
    const std::size_t before = sessions.size(), kept = ground->memory.kept().first;
    const std::size_t columns = ground == &first ? 0 : first.memory.kept().size();
    const int maps = ground == &first ? 0 : first.unused_map();
    for (const MemoryRange& range : ground->runs()) {
      runs.push_back(ground->memory.stored_run(range));
      runs.back().session += before;
    }
    sessions.insert(sessions.end(), ground->memory.sessions().begin(),
                    ground->memory.sessions().end());
    both.origins.insert(both.origins.end(), ground->origins.begin(), ground->origins.end());
    for (KnownPlace place : ground->places) {
      place.column += columns - kept;
      place.map += maps;
      both.places.push_back(place);
    }
    for (const auto& [map, datum] : ground->datums) both.datums.emplace(map + maps, datum);
    if (ground->identity != 0) both.parents.push_back(ground->identity);
  }
  both.memory.restore(std::move(sessions), runs);
  return both;
}

void take_descent(const GroundMap& from, GroundMap& into) {
  into.descent.insert(into.descent.end(), from.descent.begin(), from.descent.end());
  if (from.identity != 0) into.descent.push_back({from.identity, 0});
}

// The stored runs of a map, from a column on.
std::vector<MemoryRange> runs_of(const GroundMap& ground, std::size_t begin, int map) {
  std::vector<MemoryRange> runs;
  for (const MemoryRange& run : ground.runs()) {
    const auto at = ground.at(0.5 * static_cast<double>(run.first + run.end), 2 * kNodeSpacing);
    if (run.first >= begin && at && at->map == map) runs.push_back(run);
  }
  return runs;
}

double metres_of(const GroundMap& ground, const std::vector<MemoryRange>& ranges) {
  std::size_t columns = 0;
  for (const MemoryRange& range : ranges) columns += range.size();
  return static_cast<double>(columns) * ground.memory.spacing();
}

// The columns of the runs without those that the revisits found in the
// other track, half a patch to either side. What is left between them is kept if it is long enough
// to be searched.
std::vector<MemoryRange> new_ground(const GroundMap& ground, const std::vector<MemoryRange>& runs,
                                    const std::vector<Revisited>& revisits, double patch_m) {
  const gpr::TraceMemory& memory = ground.memory;
  const auto half = static_cast<std::size_t>(0.5 * patch_m / memory.spacing());
  std::vector<bool> known(memory.kept().end, false);
  for (const Revisited& one : revisits) {
    if (!one.trusted) continue;
    const MemoryRange run = memory.run_of(one.column);
    for (std::size_t i = std::max(run.first + half, one.column) - half;
         i < std::min(run.end, one.column + half); ++i)
      known[i] = true;
  }
  std::vector<MemoryRange> pieces;
  for (const MemoryRange& run : runs) {
    for (std::size_t i = run.first; i < run.end;) {
      MemoryRange piece{i, i};
      while (piece.end < run.end && !known[piece.end]) ++piece.end;
      const bool whole = piece.size() == run.size();
      if (whole || static_cast<double>(piece.size()) * memory.spacing() >= memory.options().least_m)
        pieces.push_back(piece);
      i = piece.end;
      while (i < run.end && known[i]) ++i;
    }
  }
  return pieces;
}

// The places of two maps as they were joined: first those of one, then those of the other.
void take_poses(GroundMap& ground, int into, int joining, const std::vector<KnownPlace>& joined) {
  auto next = joined.begin();
  for (const int map : {into, joining}) {
    for (KnownPlace& place : ground.places) {
      if (place.map == map && next != joined.end() && place.column == next->column) place = *next++;
    }
  }
}

}  // namespace

MergedMaps merge_maps(const GroundMap& first, const GroundMap& second, const GraphConfig& config) {
  check(first, second);
  GroundMap both = both_of(first, second);
  const std::size_t begin = first.memory.kept().size();
  // While they are joined, places are poses of the antennas.
  for (KnownPlace& place : both.places)
    place.pose = compose(place.pose, both.antenna_at(place.column, {}));
  const std::vector<SessionOrigin> origins = both.origins;
  for (SessionOrigin& origin : both.origins) origin.antenna.setZero();
  MergedMaps merged{GroundMap(first.memory.options()), {}, 0.0};
  std::vector<MemoryRange> kept{{0, begin}};
  MapJoiner joiner(both, begin, config);
  for (int map = first.unused_map(); map < both.unused_map(); ++map) {
    if (!both.holds(map)) continue;
    const std::vector<MemoryRange> runs = runs_of(both, begin, map);
    MapJoin& join = merged.joins.emplace_back();
    join.map = map - first.unused_map();
    join.joined = joiner.join(map, runs);
    join.proven = join.joined && join.joined->proven(config);
    if (!join.proven) {
      auto by_datum = join_by_datum(both, map, first.unused_map());
      if (!by_datum) continue;
      join.joined = std::move(by_datum);
      join.proven = join.by_datum = true;
    }
    join.into = join.joined->places.front().map;
    if (!join.by_datum) {
      join.check = check_datums(both, map, *join.joined);
      const auto there = datum_of_other(both, map, *join.joined);
      if (there) both.datums.emplace(join.into, *there);  // where it has none
    }
    const std::vector<MemoryRange> pieces =
        new_ground(both, runs, join.joined->revisits, config.patch_length);
    kept.insert(kept.end(), pieces.begin(), pieces.end());
    merged.known_m += metres_of(both, runs) - metres_of(both, pieces);
    take_poses(both, join.into, map, join.joined->places);
  }
  both.origins = origins;
  const auto to_body = [&](KnownPlace& place) {
    place.pose = compose(place.pose, between(both.antenna_at(place.column, {}), {}));
  };
  for (MapJoin& join : merged.joins) {
    if (join.joined) std::for_each(join.joined->places.begin(), join.joined->places.end(), to_body);
  }
  std::for_each(both.places.begin(), both.places.end(), to_body);
  std::sort(kept.begin(), kept.end(),
            [](const MemoryRange& a, const MemoryRange& b) { return a.first < b.first; });
  merged.ground = both.part(kept);
  const bool changed = std::any_of(merged.joins.begin(), merged.joins.end(),
                                   [](const MapJoin& join) { return join.proven; });
  if (!changed) merged.ground.parents.resize(std::min<std::size_t>(both.parents.size(), 1));
  take_descent(first, merged.ground);
  const bool all = std::all_of(merged.joins.begin(), merged.joins.end(),
                               [](const MapJoin& join) { return join.proven; });
  if (all) take_descent(second, merged.ground);  // else some of its ground is left out
  return merged;
}

}  // namespace gprodom
