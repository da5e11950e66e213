#include "map/locator.h"

#include <algorithm>
#include <cmath>

#include "map/map_path.h"

namespace gprodom {
namespace {

// m driven between two searches of all ground from before a reset. Over ten kilometres such a
// search costs thirty times a gated one (docs/revisit.md), so it is not made with every patch.
constexpr double kSearchEvery = 2.0;

// m of the newest ground that are searched. A shorter query matches at too many places; over a
// longer one the odometry then and now differs by more than the match bears.
constexpr double kLeastQuery = 6.0, kLongestQuery = 10.0;

// ln of travel times now over then that are tried. Frost and rain change the permittivity by some
// 10 %, travel times by half of that; a place is found with half a step between them as well.
constexpr double kStretches[] = {0.0, -0.05, 0.05};

constexpr double kOnePlace = 2.0;  // m; two columns whose poses are nearer are the same place

}  // namespace

Locator::Locator(const PlanarPose& antenna_in_body)
    : antenna_(antenna_in_body), next_m_(kLeastQuery) {}

void Locator::learn(const GroundMap& ground, std::size_t end_of_before) {
  search_.emplace(*ground.memory.filter(), ground.memory.spacing());
  for (std::size_t column = ground.memory.kept().first; column < end_of_before;) {
    const gpr::MemoryRange run = ground.memory.run_of(column);
    search_->add_run(column, ground.memory.patch(run));
    column = run.end;
  }
}

std::optional<Hypothesis> Locator::find(const GroundMap& ground, std::size_t end_of_before,
                                        const PlanarPose& newest_body, double travelled_m) {
  const gpr::TraceMemory& memory = ground.memory;
  const gpr::MemoryRange kept = memory.kept();
  if (kept.end <= end_of_before || kept.first >= end_of_before) return std::nullopt;
  next_m_ = travelled_m + kSearchEvery;
  return place(ground, end_of_before, memory.run_of(kept.end - 1), newest_body);
}

double Locator::least_query() { return kLeastQuery; }

std::optional<Hypothesis> Locator::place(const GroundMap& ground, std::size_t end_of_before,
                                         gpr::MemoryRange newest, const PlanarPose& newest_body) {
  const gpr::TraceMemory& memory = ground.memory;
  const gpr::MemoryRange kept = memory.kept();
  const auto columns = [&](double metres) {
    return static_cast<std::size_t>(std::lround(metres / memory.spacing()));
  };
  newest.first = std::max(newest.first, newest.end - std::min(newest.end, columns(kLongestQuery)));
  if (newest.size() < columns(kLeastQuery)) return std::nullopt;

  if (!search_) learn(ground, end_of_before);
  // Ground that was driven over twice is one place. Places of different maps cannot be compared, so
  // they count as one place too; a revisit must prove the hypothesis anyway.
  const double reach = 2 * kNodeSpacing;
  const auto same_place = [&](double a, double b) {
    const auto at_a = ground.at(a, reach), at_b = ground.at(b, reach);
    return at_a && at_b &&
           (at_a->map != at_b->map || (at_a->pose.p - at_b->pose.p).norm() < kOnePlace);
  };
  gpr::GlobalMatch match;
  double stretch = 0.0;
  for (const double tried : kStretches) {
    if (tried != 0.0 && !memory.can_stretch()) continue;
    const gpr::GlobalMatch found = search_->find(memory.patch(newest, tried), same_place);
    if (!found.accepted || (match.accepted && found.margin < match.margin)) continue;
    match = found;
    stretch = tried;
  }
  if (!match.accepted) return std::nullopt;
  // Uses the query's end, where the robot is, and not its centre: an error of the heading then has
  // less effect.
  const double ahead = 0.5 * static_cast<double>(newest.size() - 1);
  double column = match.column + (match.mirrored ? -ahead : ahead);
  column =
      std::clamp(column, static_cast<double>(kept.first), static_cast<double>(end_of_before - 1));
  const auto then = ground.at(column, reach);
  if (!then) return std::nullopt;
  // The memory has the direction of driving, the pose the heading. They differ when driving
  // backwards.
  const int driven_then = memory.column(static_cast<std::size_t>(column)).direction;
  const int driven_now = memory.column(newest.end - 1).direction;
  const bool about = match.mirrored == (driven_then == driven_now);
  PlanarPose antenna = compose(then->pose, antenna_);
  if (about) antenna = compose(antenna, {{0.0, 0.0}, M_PI});
  const PlanarPose body = compose(antenna, between(antenna_, {}));
  return Hypothesis{compose(body, between(newest_body, {})), then->map, stretch};
}

}  // namespace gprodom
