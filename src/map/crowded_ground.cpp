#include "map/crowded_ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "map/path/map_path.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

// m along a track: a pass beside has a place so near, and in the same run it is the pass itself.
constexpr double kNear = 2.0 * kNodeSpacing;

struct Place {
  KnownPlace known;
  PlanarPose antenna;  // in the map
  std::size_t run = 0;
};

std::vector<Place> places_by_run(const GroundMap& ground,
                                 const std::vector<gpr::MemoryRange>& runs) {
  std::vector<Place> all;
  std::size_t run = 0;
  for (const KnownPlace& place : ground.places) {
    while (run < runs.size() && place.column >= runs[run].end) ++run;
    if (run == runs.size() || place.column < runs[run].first) continue;
    all.push_back({place, compose(place.pose, ground.antenna_at(place.column, {})), run});
  }
  return all;
}

// Finds places near by without a look at all of them: a map of ten kilometres has twenty thousand.
class Squares {
 public:
  explicit Squares(double side_m) : side_m_(side_m) {}

  void add(const Eigen::Vector2d& p, std::size_t place) { places_[at(p)].push_back(place); }

  // At least those within a side, in the order of their numbers.
  std::vector<std::size_t> near(const Eigen::Vector2d& p) const {
    std::vector<std::size_t> near;
    const auto [x, y] = at(p);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto square = places_.find({x + dx, y + dy});
        if (square != places_.end())
          near.insert(near.end(), square->second.begin(), square->second.end());
      }
    }
    std::sort(near.begin(), near.end());
    return near;
  }

 private:
  std::pair<int, int> at(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d corner = (p / side_m_).array().floor();
    return {static_cast<int>(corner.x()), static_cast<int>(corner.y())};
  }
  double side_m_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> places_;
};

// The passes beside a place among these older places, in order.
std::vector<Pass> passes_beside(const Place& here, const std::vector<Place>& places,
                                const std::vector<std::size_t>& older) {
  PassFinder finder(here.antenna, kNear, kLateralGate, 0.0);
  std::size_t last = 0;
  for (const std::size_t i : older) {
    const Place& place = places[i];
    const bool same_pass =
        place.run == here.run && std::abs(place.known.distance_m - here.known.distance_m) < kNear;
    if (same_pass || place.known.map != here.known.map) continue;
    if (i != last + 1 || place.run != places[last].run) finder.interrupt();
    finder.offer(i, place.antenna, true);
    last = i;
  }
  return finder.passes();
}

// Of each place, whether enough of the older ones lie beside it that are not crowded themselves,
// and one of them within the footprint: a lane beside one that was driven often has ground of its
// own.
std::vector<bool> are_known(const std::vector<Place>& places, double lateral_sigma_m) {
  Squares kept(kNear + kLateralGate);
  std::vector<bool> known;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector2d& p = places[i].antenna.p;
    const std::vector<Pass> passes = passes_beside(places[i], places, kept.near(p));
    known.push_back(is_crowded(passes, lateral_sigma_m) &&
                    std::any_of(passes.begin(), passes.end(), [&](const Pass& pass) {
                      return std::abs(pass.lateral) < lateral_sigma_m;
                    }));
    if (!known.back()) kept.add(p, i);
  }
  return known;
}

// The columns of the run from the first known place of each stretch to its last one, or to an end
// of the run that has no other place.
std::vector<gpr::MemoryRange> stretches(const std::vector<Place>& places,
                                        const std::vector<bool>& known, std::size_t run,
                                        gpr::MemoryRange columns) {
  std::vector<gpr::MemoryRange> all;
  bool is_first = true, was_known = false;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].run != run) continue;
    const std::size_t column = places[i].known.column;
    if (known[i] && !was_known) all.push_back({is_first ? columns.first : column, column});
    if (known[i]) all.back().end = column + 1;
    was_known = known[i];
    is_first = false;
  }
  if (was_known) all.back().end = columns.end;
  return all;
}

}  // namespace

bool is_crowded(const std::vector<Pass>& passes, double lateral_sigma_m) {
  const auto beside = std::count_if(passes.begin(), passes.end(), [](const Pass& pass) {
    return std::abs(pass.along) <= kNodeSpacing && std::abs(pass.lateral) < kLateralGate;
  });
  return static_cast<double>(beside) >= kLateralGate / lateral_sigma_m;
}

GroundMap without_crowded(GroundMap ground, double lateral_sigma_m) {
  const std::vector<gpr::MemoryRange> runs = ground.runs();
  const std::vector<Place> places = places_by_run(ground, runs);
  const std::vector<bool> known = are_known(places, lateral_sigma_m);
  const auto least = static_cast<std::size_t>(
      std::lround(ground.memory.options().least_m / ground.memory.spacing()));
  std::vector<gpr::MemoryRange> stays;
  bool all = true;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    std::size_t from = runs[run].first;
    for (const gpr::MemoryRange& stretch : stretches(places, known, run, runs[run])) {
      if (stretch.size() < least) continue;
      if (stretch.first - from >= least) stays.push_back({from, stretch.first});
      from = stretch.end;
      all = false;
    }
    const bool whole = from == runs[run].first;
    if (whole || runs[run].end - from >= least) stays.push_back({from, runs[run].end});
  }
  if (all) return ground;
  GroundMap thinned = ground.part(stays);
  thinned.descent = std::move(ground.descent);
  if (ground.identity != 0) thinned.descent.push_back({ground.identity, 0});
  return thinned;
}

}  // namespace gprodom
