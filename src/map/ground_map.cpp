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

int GroundMap::unused_map() const {
  int highest = -1;
  for (const KnownPlace& place : places) highest = std::max(highest, place.map);
  return highest + 1;
}

}  // namespace gprodom
