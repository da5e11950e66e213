#include "map/locator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "map/path/map_path.h"

namespace gprodom {
namespace {

// m driven between two searches of all ground from before a reset. Ground of another day is
// searched for likely changes and for others, each at this distance. Over ten kilometres such a
// search costs thirty times a gated one (docs/revisit.md), so it is not made with every patch.
constexpr double kSearchEvery = 2.0;

// m of the newest ground that are searched. A shorter query matches at too many places; over a
// longer one the odometry then and now differs by more than the match bears.
constexpr double kLeastQuery = 6.0, kLongestQuery = 10.0;

// m of the newest ground that are not searched, a patch and more. A hypothesis is the best of all
// places for the ground that was searched, so that ground says nothing more for it: other ground
// must prove it, which are the patches from then on.
constexpr double kForProof = 2.0;

// ln of travel times now over then that are tried. Frost and rain change the permittivity by 10 to
// 20 %, travel times by half of that; a place is found with half a step between them as well.
const std::vector<double> kStretches = {0.0, -0.05, 0.05, -0.1, 0.1};
// A drive tries the likely ones and the others by turns, since each costs a search of all ground.
const std::vector<double> kLikely = {0.0, -0.05, 0.05}, kUnlikely = {-0.1, 0.1};

// Near a place, where little ground is searched, finer ones: at 1 % an echo from 25 periods deep is
// off by a quarter of a period. A place found says which of the above is near.
constexpr double kFineStep = 0.01;
constexpr int kFineSteps = 5;           // to either side
constexpr double kFarthestTold = 0.12;  // of a place told, at twice that step
const std::vector<double> kFineTurns = {0.0, -0.4, 0.4, -0.8, 0.8, -1.2, 1.2};

// Share of new ground after which the track's own ground is learnt again. As it grows, all of that
// costs six times as much as to learn it once, however long it becomes.
constexpr double kLearnAgain = 0.2;

// Columns that are learnt at once, a multiple of GlobalSearchOptions::thinning: as floats, a long
// run takes four times the memory that it is stored in.
constexpr std::size_t kBlock = 4000;

constexpr double kOnePlace = 2.0;     // m; two columns whose poses are nearer are the same place
constexpr double kFoundWithin = 2.0;  // m, of a place found by the search
constexpr double kLeastNear = 4.0;    // m of ground from which a change is supposed near a place

std::size_t columns_of(const gpr::TraceMemory& memory, double metres) {
  return static_cast<std::size_t>(std::lround(metres / memory.spacing()));
}

// So many steps of a stretch to either side of `middle`, the nearest first.
std::vector<double> stretches_round(double middle, double step, int steps) {
  std::vector<double> all = {middle};
  for (int i = 1; i <= steps; ++i) {
    all.push_back(middle - i * step);
    all.push_back(middle + i * step);
  }
  return all;
}

// Earlier ground within so much of a place.
gpr::GlobalSearch search_near(const GroundMap& ground, std::size_t end_of_before,
                              const Locator::Near& near) {
  const gpr::TraceMemory& memory = ground.memory;
  gpr::GlobalSearchOptions options;
  options.turns = kFineTurns;
  gpr::GlobalSearch search(*memory.filter(), memory.spacing(), options);
  std::vector<std::size_t> columns;
  for (const KnownPlace& place : ground.places) {
    if (place.map == near.map && place.column < end_of_before &&
        (place.pose.p - near.at).norm() <= near.within_m)
      columns.push_back(place.column);
  }
  std::sort(columns.begin(), columns.end());
  for (auto first = columns.begin(); first != columns.end();) {
    const gpr::MemoryRange run = memory.run_of(*first);
    const auto end = std::lower_bound(first, columns.end(), run.end);
    search.add_run(*first, memory.patch({*first, *(end - 1) + 1}));
    first = end;
  }
  return search;
}

}  // namespace

Locator::Locator() : next_m_(kLeastQuery) {}

void Locator::learn(const GroundMap& ground, std::size_t end) {
  search_.emplace(*ground.memory.filter(), ground.memory.spacing());
  for (std::size_t column = ground.memory.kept().first; column < end;) {
    const std::size_t to = std::min({ground.memory.run_of(column).end, end, column + kBlock});
    search_->add_run(column, ground.memory.patch({column, to}));
    column = to;
  }
  learned_ = end;
}

std::optional<gpr::MemoryColumn> Locator::last_searched(const gpr::TraceMemory& memory,
                                                        std::size_t end_of_before) {
  const std::size_t proof = columns_of(memory, kForProof);
  if (memory.newest_columns(end_of_before) <= proof) return std::nullopt;
  return memory.newest_column(proof);
}

// Whether it is stored yet or not.
Locator::Driven Locator::newest(const GroundMap& ground, std::size_t end_of_before) {
  const gpr::TraceMemory& memory = ground.memory;
  Driven driven;
  const std::optional<gpr::MemoryColumn> last = last_searched(memory, end_of_before);
  if (!last) return driven;
  const std::size_t proof = columns_of(memory, kForProof);
  driven.columns =
      std::min(memory.newest_columns(end_of_before) - proof, columns_of(memory, kLongestQuery));
  driven.without = [&memory, n = driven.columns, proof](const gpr::TraceChange& change) {
    return gpr::Columns(memory.newest_ground(n + proof, change).topRows(n));
  };
  driven.direction = last->direction;
  return driven;
}

// The ground as it would be without one change or another.
std::vector<gpr::GlobalQuery> Locator::queries(const Driven& driven, bool can_undo,
                                               const std::vector<double>& stretches) {
  if (!can_undo) return {{driven.without({}), {}}};
  std::vector<gpr::GlobalQuery> all;
  all.reserve(stretches.size());
  for (const double stretch : stretches)
    all.push_back({driven.without({stretch, 0.0}), driven.without({stretch, 0.5 * M_PI})});
  return all;
}

std::optional<Hypothesis> Locator::find(const GroundMap& ground, std::size_t end_of_before,
                                        const PlanarPose& newest_body, const PlanarPose& antenna,
                                        double travelled_m, const OwnGround& own) {
  const gpr::TraceMemory& memory = ground.memory;
  if (memory.kept().first >= std::max(end_of_before, own.end)) return std::nullopt;
  Driven driven = newest(ground, end_of_before);
  if (driven.columns < columns_of(memory, kLeastQuery)) return std::nullopt;
  const bool by_turns = memory.can_undo();
  driven.body = newest_body;
  driven.antenna = antenna;
  next_m_ = travelled_m + (by_turns ? kSearchEvery / 2 : kSearchEvery);
  const bool likely = !by_turns || std::exchange(likely_, !likely_);
  return place(ground, end_of_before, driven, likely ? kLikely : kUnlikely, own);
}

double Locator::least_query() { return kLeastQuery; }

std::optional<gpr::TraceChange> Locator::change_near(const GroundMap& ground,
                                                     std::size_t end_of_before, const Near& near) {
  const gpr::TraceMemory& memory = ground.memory;
  const Driven driven = newest(ground, end_of_before);
  if (driven.columns < columns_of(memory, kLeastNear)) return std::nullopt;
  const std::vector<double> stretches = stretches_round(
      0.0, 2 * kFineStep, static_cast<int>(std::lround(kFarthestTold / (2 * kFineStep))));
  const gpr::GlobalMatch match =
      search_near(ground, end_of_before, {near.map, near.at, near.within_m + kLongestQuery})
          .find(queries(driven, memory.can_undo(), stretches));
  if (!match.valid) return std::nullopt;
  return gpr::TraceChange{stretches[match.query], match.turn};
}

std::optional<Hypothesis> Locator::place(const GroundMap& ground, std::size_t end_of_before,
                                         gpr::MemoryRange newest, const PlanarPose& newest_body) {
  const gpr::TraceMemory& memory = ground.memory;
  newest.first =
      std::max(newest.first, newest.end - std::min(newest.end, columns_of(memory, kLongestQuery)));
  if (newest.size() < columns_of(memory, kLeastQuery)) return std::nullopt;
  const auto without = [&](const gpr::TraceChange& change) { return memory.patch(newest, change); };
  const int direction = memory.column(newest.end - 1).direction;
  const PlanarPose antenna = ground.antenna_at(newest.first, {});
  return place(ground, end_of_before, {newest.size(), without, direction, newest_body, antenna},
               kStretches);
}

std::optional<Hypothesis> Locator::place(const GroundMap& ground, std::size_t end_of_before,
                                         const Driven& driven, const std::vector<double>& stretches,
                                         const OwnGround& own) {
  const gpr::TraceMemory& memory = ground.memory;
  const double fresh = static_cast<double>(own.end) - static_cast<double>(learned_);
  if (!search_ || fresh > kLearnAgain * static_cast<double>(memory.kept().size()))
    learn(ground, std::max(end_of_before, own.end));
  // Ground that was driven over twice is one place. Places of different maps cannot be compared, so
  // they count as one place too; a revisit must prove the hypothesis anyway.
  const double reach = 2 * kNodeSpacing;
  const auto is_own = [&](double column) { return column >= static_cast<double>(end_of_before); };
  const auto place_of = [&](double column) {
    return is_own(column) ? own.place(column) : ground.at(column, reach);
  };
  const auto same_place = [&](double a, double b) {
    const auto at_a = place_of(a), at_b = place_of(b);
    return at_a && at_b &&
           (at_a->map != at_b->map || (at_a->pose.p - at_b->pose.p).norm() < kOnePlace);
  };
  const gpr::GlobalMatch match =
      search_->find(queries(driven, memory.can_undo(), stretches), same_place);
  if (!match.accepted) return std::nullopt;
  // Uses the query's end, where the robot is, and not its centre: an error of the heading then has
  // less effect.
  const double ahead = 0.5 * static_cast<double>(driven.columns - 1);
  double column = match.column + (match.mirrored ? -ahead : ahead);
  column = std::clamp(column, static_cast<double>(memory.kept().first),
                      static_cast<double>(learned_ - 1));
  const auto then = place_of(column);
  if (!then) return std::nullopt;
  // The memory has the direction of driving, the pose the heading. They differ when driving
  // backwards.
  const auto number = static_cast<std::size_t>(column);
  const int driven_then = memory.column(number).direction;
  const bool about = match.mirrored == (driven_then == driven.direction);
  PlanarPose antenna = compose(then->pose, ground.antenna_at(number, driven.antenna));
  if (about) antenna = compose(antenna, {{0.0, 0.0}, M_PI});
  const PlanarPose body = compose(antenna, between(driven.antenna, {}));
  Hypothesis found{compose(body, between(driven.body, {})), then->map, {}, is_own(column)};
  if (found.own || !memory.can_undo()) return found;
  const std::vector<double> finer = stretches_round(stretches[match.query], kFineStep, kFineSteps);
  const gpr::GlobalMatch fine =
      search_near(ground, end_of_before, {then->map, body.p, kLongestQuery + kFoundWithin})
          .find(queries(driven, true, finer));
  if (fine.valid) found.change = {finer[fine.query], fine.turn};
  return found;
}

}  // namespace gprodom
