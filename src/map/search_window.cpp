#include "map/search_window.h"

#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

// Errors of a revisit over those that its match foretells, RMS: what tracks 20 and 40 cm apart on
// real ground show (sigma_ratio of bench/revisit_along.py).
constexpr double kSigmaFactor = 1.3;

constexpr double kChosenFrom = 15.0;  // changes; a hypothesis has the best of them

// How far aside the ground of a match may lie, as a standard deviation, since the side is not
// known: rho = exp(-d^2 / (2 sigma^2)) within the footprint sigma. No less than sigma: some ground,
// as layers, is the same far aside.
double aside_of(double rho, double sigma) {
  constexpr double kLeast = 0.05;
  return sigma * std::sqrt(std::max(1.0, -2.0 * std::log(std::max(rho, kLeast))));
}

}  // namespace

gpr::RevisitSearchOptions search_options(const GraphConfig& config, bool changed) {
  gpr::RevisitSearchOptions options;
  options.patch_m = config.patch_length;
  if (!changed) return options;
  // One of several changes was chosen, by the same ground in part. That it is this ground at all
  // rests on more than the patches: on a search of all ground, or on what was told.
  options.nowhere = 1.0 - (1.0 - options.nowhere) / kChosenFrom;
  options.clear_once = false;
  return options;
}

gpr::SearchWindow window_on(const gpr::TraceMemory& memory, std::size_t column, double ahead_m,
                            double bound_m, double reach_m) {
  const gpr::MemoryRange run = memory.run_of(column);
  gpr::SearchWindow window;
  window.run = run.first;
  window.expected =
      static_cast<double>(column) + memory.column(column).direction * ahead_m / memory.spacing();
  window.bound_m = bound_m;
  const double reach = (bound_m + reach_m) / memory.spacing() + 4.0;
  const auto clamped = [&](double number) {
    return static_cast<std::size_t>(
        std::clamp(number, static_cast<double>(run.first), static_cast<double>(run.end)));
  };
  window.first = clamped(std::floor(window.expected - reach));
  window.features = memory.patch({window.first, clamped(std::ceil(window.expected + reach))});
  return window;
}

// Overlapping patches share their errors. So the variance is divided by the share of new ground:
// all patches together count as often as they fit into the ground.
RevisitEdge edge_of(const gpr::RevisitMatch& match, double moved_m, const GraphConfig& config) {
  const double fresh = std::min(1.0, moved_m / config.patch_length);
  RevisitEdge edge;
  edge.sigma_m = std::max(kLeastRevisitSigma, kSigmaFactor * match.sigma_m) / std::sqrt(fresh);
  edge.lateral_sigma_m = aside_of(match.correlation, config.lateral_sigma) / std::sqrt(fresh);
  return edge;
}

}  // namespace gprodom
