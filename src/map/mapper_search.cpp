// Mapper: the windows of the memory in which the newest ground is searched.
#include <algorithm>
#include <cmath>
#include <utility>

#include "map/mapper.h"

namespace gprodom {
namespace {

// m between two tracks. Further apart they see other ground: of 40 cm, a coherence of 0.3 is left
// in the best band (docs/revisit.md).
constexpr double kLateralGate = 0.4;

constexpr std::size_t kMaxWindows = 2;  // passes over a place that are searched

}  // namespace

// The stretches of stored ground on which, by the poses, the query may lie. Those with the smallest
// lateral offset come first.
std::vector<gpr::SearchWindow> Mapper::windows(const gpr::MemoryColumn& query) const {
  const MapPath::Place at = path_.place(query.time, query.distance_m);
  const PlanarPose here = compose(body_at(at), antenna_);
  const double sigma = sigma_m();
  const double gate = std::clamp(kGateSigmas * sigma, kGateMin, kGateMax);
  const double aside = kLateralGate + std::min(kGateSigmas * sigma, kGateMax);
  // Leaves out the query itself and the ground just before it.
  const double newest = path_.travelled_at(at.node) - config_.patch_length - gate;

  PassFinder finder(here, antenna_, gate + kNodeSpacing, aside);
  for (std::size_t node = 0; node < at.node && path_.travelled_at(node) < newest; ++node) {
    if (path_.begins_piece(node)) finder.interrupt();
    finder.offer(node, graph_->nodes()[node], false);
  }
  std::vector<Pass> passes = finder.passes();
  const auto is_forgotten = [&](const Pass& pass) {
    return pass.from_before ? ground_.places[pass.place].column < ground_.memory.kept().first
                            : !column_at(pass.place);
  };
  passes.erase(std::remove_if(passes.begin(), passes.end(), is_forgotten), passes.end());
  if (located_ || hypothesis_) {
    const PlanarPose in_map = located_ ? here : compose(hypothesis_->map_from_track, here);
    PassFinder before(in_map, antenna_, gate + kNodeSpacing, aside);
    for (std::size_t i = 0; i < ground_.places.size(); ++i) {
      const KnownPlace& place = ground_.places[i];
      if (place.map == (located_ ? map_ : hypothesis_->map)) before.offer(i, place.pose, true);
    }
    std::vector<Pass> found = before.passes();
    found.erase(std::remove_if(found.begin(), found.end(), is_forgotten), found.end());
    passes.insert(passes.begin(), found.begin(), found.end());
  }
  passes = in_search_order(std::move(passes), config_.lateral_sigma);
  // Passes of an unproven hypothesis come first.
  if (!located_) {
    std::stable_partition(passes.begin(), passes.end(),
                          [](const Pass& p) { return p.from_before; });
  }
  passes.resize(std::min(passes.size(), kMaxWindows));
  std::vector<gpr::SearchWindow> windows;
  windows.reserve(passes.size());
  for (const Pass& pass : passes) windows.push_back(window_at(pass, query, gate));
  return windows;
}

PlanarPose Mapper::body_at(const MapPath::Place& place) const {
  return graph_->place(place.node, place.at, place.way);
}

gpr::SearchWindow Mapper::window_at(const Pass& pass, const gpr::MemoryColumn& query,
                                    double gate) const {
  const gpr::TraceMemory& memory = ground_.memory;
  const std::size_t column =
      pass.from_before ? ground_.places[pass.place].column : *column_at(pass.place);
  const double distance =
      pass.from_before ? ground_.places[pass.place].distance_m : path_.distance_of(pass.place);
  const gpr::MemoryColumn then = memory.column(column);
  const gpr::MemoryRange run = memory.run_of(column);
  gpr::SearchWindow window;
  window.run = run.first;
  // Distances in the memory are those of the odometry.
  const double longer = pass.from_before ? 1.0 : std::exp(-graph_->slip(pass.place));
  const double ahead = distance + longer * pass.along - then.distance_m;
  window.expected = static_cast<double>(column) + then.direction * ahead / memory.spacing();
  window.bound_m = longer * gate;
  predict_stretch(pass, query, window);
  // The memory has the direction of driving, the poses have the heading.
  window.mirrored = pass.turned != (then.direction != query.direction);
  const double reach = (window.bound_m + search_->reach_m()) / memory.spacing() + 4.0;
  const auto clamped = [&](double number) {
    return static_cast<std::size_t>(
        std::clamp(number, static_cast<double>(run.first), static_cast<double>(run.end)));
  };
  window.first = clamped(std::floor(window.expected - reach));
  window.features = memory.patch({window.first, clamped(std::ceil(window.expected + reach))});
  return window;
}

// The stretch that the graph's estimates of the slip there and here let expect. The slip there gets
// its prior variance: the posterior is correlated with other passes through the revisits.
void Mapper::predict_stretch(const Pass& pass, const gpr::MemoryColumn& query,
                             gpr::SearchWindow& window) const {
  const std::size_t here = path_.place(query.time, query.distance_m).node;
  const double slip_then = pass.from_before ? 0.0 : graph_->slip(pass.place);
  const double sigma_now = graph_->slip_sigma(here);
  // The slip of an earlier track is not known; its variance is taken to be that of this one.
  const double sigma_then = pass.from_before ? sigma_now : graph_->slip_sigma(pass.place);
  window.stretch = graph_->slip(here) - slip_then;
  window.stretch_sigma = std::hypot(std::sqrt(newest_node_.covariance(4, 4)), sigma_then);
  const double seconds = last_query_ ? to_seconds(query.time - last_query_->time) : 0.0;
  const double kept = slip_.correlation(seconds);
  window.stretch_change = std::hypot(sigma_now, sigma_then) * std::sqrt(1 - kept * kept);
}

}  // namespace gprodom
