#include "map/ground_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "map/map_path.h"

namespace gprodom {

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

GroundMap GroundMap::part(const std::vector<gpr::MemoryRange>& ranges) const {
  GroundMap part(memory.options());
  part.format = format;
  std::size_t before = 0;  // columns of the part so far
  for (const gpr::MemoryRange& range : ranges) {
    for (std::size_t first = range.first, end = first; first < range.end; first = end) {
      end = std::min(range.end, memory.run_of(first).end);
      const gpr::MemoryColumn begin = memory.column(first);
      std::vector<TimeNs> times;
      for (std::size_t i = first; i < end; ++i) times.push_back(memory.column(i).time);
      part.memory.restore_run(*memory.filter(), times, begin.distance_m, begin.direction,
                              memory.patch({first, end}));
    }
    for (KnownPlace place : places) {
      if (place.column < range.first || place.column >= range.end) continue;
      place.column += before - range.first;
      part.places.push_back(place);
    }
    before += range.size();
  }
  return part;
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
