#include "map/ground_map.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/sealed_bytes.h"
#include "map/path/map_path.h"

namespace gprodom {
namespace {

// 32 kB of a file, and a drive a day for three years. An older file that is met again is not known
// to be in the map any more, and is set aside.
constexpr std::size_t kMostAncestors = 2000;

}  // namespace

std::optional<GroundMap::At> GroundMap::at(double column, double reach_m) const {
  const gpr::MemoryRange kept = memory.kept();
  if (!(column >= static_cast<double>(kept.first)) || !(column < static_cast<double>(kept.end)))
    return std::nullopt;
  const auto number = static_cast<std::size_t>(column);
  const gpr::MemoryRange run = memory.run_of(number);
  const gpr::MemoryColumn whole = memory.column(number);
  const double distance = whole.distance_m + whole.direction *
                                                 (column - static_cast<double>(number)) *
                                                 memory.spacing();
  const auto after =
      std::upper_bound(places.begin(), places.end(), number,
                       [](std::size_t n, const KnownPlace& p) { return n < p.column; });
  const KnownPlace* near = nullptr;
  const KnownPlace* other = nullptr;
  for (auto i = after == places.begin() ? after : after - 1; i != places.end() && i <= after; ++i) {
    const bool same_run = i->column >= run.first && i->column < run.end;
    if (!same_run || std::abs(i->distance_m - distance) > reach_m) continue;
    other = near;
    near = &*i;
    if (other && std::abs(other->distance_m - distance) < std::abs(near->distance_m - distance))
      std::swap(near, other);
  }
  if (!near) return std::nullopt;
  double curvature = 0.0;
  if (other && other->map == near->map) {
    const PlanarPose step = between(near->pose, other->pose);
    if (std::abs(step.p.x()) > 0.3 * reach_m) curvature = step.yaw / step.p.x();
  }
  return At{compose(near->pose, along_arc(distance - near->distance_m, curvature)), near->map};
}

void GroundMap::changes() {
  if (identity == 0) return;
  parents = {identity};
  identity = 0;
}

std::uint64_t GroundMap::taken_from() const {
  return identity != 0 || parents.empty() ? identity : parents.front();
}

bool GroundMap::goes_on_from(std::uint64_t file) const {
  if (version == 1 || (file == 0 && parents.empty())) return true;
  return file != 0 &&
         (identity == file || std::find(parents.begin(), parents.end(), file) != parents.end());
}

void GroundMap::extended(std::size_t first, TimeNs now, bool new_drive) {
  if (identity != 0) descent.push_back({identity, 0});
  changes();
  if (new_drive) {
    const gpr::Columns begin = memory.patch({first, memory.kept().end});
    ByteWriter out;
    out.put_all(parents.data(), parents.size());
    out.put(memory.column(first).time);
    out.put_all(begin.data(), static_cast<std::size_t>(begin.size()));
    descent.push_back({checksum(out.bytes()), now});
  }
  if (descent.size() > kMostAncestors)
    descent.erase(descent.begin(), descent.end() - static_cast<std::ptrdiff_t>(kMostAncestors));
  descent.back().until = now;
}

std::vector<gpr::MemoryRange> GroundMap::runs() const {
  std::vector<gpr::MemoryRange> runs;
  const gpr::MemoryRange kept = memory.kept();
  for (std::size_t first = kept.first; first < kept.end; first = runs.back().end)
    runs.push_back(memory.run_of(first));
  return runs;
}

GroundMap GroundMap::part(const std::vector<gpr::MemoryRange>& ranges) const {
  GroundMap part(memory.options());
  part.format = format;
  part.identity = identity;
  part.parents = parents;
  part.changes();
  std::vector<gpr::MemoryRange> pieces;  // each within a run
  std::size_t before = 0;                // columns of the part so far
  for (const gpr::MemoryRange& range : ranges) {
    for (std::size_t first = range.first, end = first; first < range.end; first = end) {
      end = std::min(range.end, memory.run_of(first).end);
      pieces.push_back({first, end});
    }
    for (KnownPlace place : places) {
      if (place.column < range.first || place.column >= range.end) continue;
      place.column += before - range.first;
      part.places.push_back(place);
    }
    before += range.size();
  }
  for (const auto& [map, datum] : datums)
    if (part.holds(map)) part.datums.emplace(map, datum);
  if (memory.sessions().empty()) {
    part.version = 1;
    for (const gpr::MemoryRange& piece : pieces) restore_features(piece, part.memory);
  } else {
    restore_sessions(pieces, part);
  }
  return part;
}

GroundMap GroundMap::features_alone() const {
  GroundMap features(memory.options());
  features.format = format;
  features.places = places;
  features.version = 1;
  for (const gpr::MemoryRange& run : runs()) restore_features(run, features.memory);
  return features;
}

void GroundMap::restore_features(gpr::MemoryRange piece, gpr::TraceMemory& into) const {
  const gpr::MemoryColumn begin = memory.column(piece.first);
  std::vector<TimeNs> times;
  for (std::size_t i = piece.first; i < piece.end; ++i) times.push_back(memory.column(i).time);
  into.restore_run(*memory.filter(), times, begin.distance_m, begin.direction, memory.patch(piece));
}

// The sessions that the pieces do not need are left out.
void GroundMap::restore_sessions(const std::vector<gpr::MemoryRange>& pieces,
                                 GroundMap& into) const {
  std::vector<gpr::StoredRun> runs;
  std::map<std::size_t, std::size_t> number;  // of each session, then and in the part
  for (const gpr::MemoryRange& piece : pieces) {
    runs.push_back(memory.stored_run(piece));
    number.emplace(runs.back().session, 0);
  }
  std::vector<gpr::BandLimit> sessions;
  for (auto& [session, in_part] : number) {
    in_part = sessions.size();
    sessions.push_back(memory.sessions()[session]);
    into.origins.push_back(origins.at(session));
  }
  for (gpr::StoredRun& run : runs) run.session = number.at(run.session);
  into.memory.restore(std::move(sessions), runs);
}

PlanarPose GroundMap::antenna_at(std::size_t column, const PlanarPose& unknown) const {
  if (origins.empty()) return unknown;
  return {origins.at(memory.session_of(column)).antenna.head<2>(), 0.0};
}

bool GroundMap::holds(int map) const {
  return std::any_of(places.begin(), places.end(),
                     [map](const KnownPlace& place) { return place.map == map; });
}

int GroundMap::unused_map() const {
  int highest = -1;
  for (const KnownPlace& place : places) highest = std::max(highest, place.map);
  return highest + 1;
}

}  // namespace gprodom
