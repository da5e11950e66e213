#include "map/crowded_ground.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "map/path/map_path.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

// m along its run from a place: what lies nearer in the same run is no other pass.
constexpr double kSamePass = 2.0;

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

// Of each place, whether enough of the older ones lie beside it that are not crowded themselves.
std::vector<bool> crowded(const std::vector<Place>& places, double lateral_sigma_m) {
  double arm_m = 0.0;
  for (const Place& place : places)
    arm_m = std::max(arm_m, (place.antenna.p - place.known.pose.p).norm());
  std::vector<bool> crowded;
  for (const Place& here : places) {
    PassFinder finder(here.antenna, 2.0 * kNodeSpacing, kLateralGate, arm_m);
    for (std::size_t i = 0; i < crowded.size(); ++i) {
      const Place& older = places[i];
      const bool same_pass = older.run == here.run &&
                             std::abs(older.known.distance_m - here.known.distance_m) < kSamePass;
      if (i > 0 && older.run != places[i - 1].run) finder.interrupt();
      if (crowded[i] || same_pass || older.known.map != here.known.map) {
        finder.interrupt();
      } else if (finder.may_be_near(older.known.pose)) {
        finder.offer(i, older.antenna, true);
      }
    }
    crowded.push_back(is_crowded(finder.passes(), lateral_sigma_m));
  }
  return crowded;
}

// The columns of the run from the first crowded place of each stretch to its last one, or to an end
// of the run that has no other place.
std::vector<gpr::MemoryRange> stretches(const std::vector<Place>& places,
                                        const std::vector<bool>& crowded, std::size_t run,
                                        gpr::MemoryRange columns) {
  std::vector<gpr::MemoryRange> all;
  bool is_first = true, was_crowded = false;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].run != run) continue;
    const std::size_t column = places[i].known.column;
    if (crowded[i] && !was_crowded) all.push_back({is_first ? columns.first : column, column});
    if (crowded[i]) all.back().end = column + 1;
    was_crowded = crowded[i];
    is_first = false;
  }
  if (was_crowded) all.back().end = columns.end;
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
  const std::vector<bool> is_crowded = crowded(places, lateral_sigma_m);
  const auto least = static_cast<std::size_t>(
      std::lround(ground.memory.options().least_m / ground.memory.spacing()));
  std::vector<gpr::MemoryRange> stays;
  bool all = true;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    std::size_t from = runs[run].first;
    for (const gpr::MemoryRange& stretch : stretches(places, is_crowded, run, runs[run])) {
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
