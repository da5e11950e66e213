// What the mapper and the merging of maps share: where ground is searched, and what a place found
// is worth as a revisit.
#pragma once

#include <cstddef>

#include "estimation/planar_geometry.h"
#include "gpr/revisit/revisit_search.h"
#include "gpr/revisit/trace_memory.h"
#include "gprodom/config.h"

namespace gprodom {

// m between two tracks. Further apart they see other ground: hardly a revisit is accepted
// (docs/revisit.md, "Variance").
constexpr double kLateralGate = 0.4;

// Ground is looked for within three standard deviations of the position. The least is what a
// covariance that is too small must not hide; the most bounds the cost of a search, and the places
// that could match by chance.
constexpr double kGateSigmas = 3.0;
constexpr double kGateMin = 0.6, kGateMax = 5.0;  // m
// m, standard deviation of a position; beyond, the ground there may lie outside of the search.
constexpr double kLostSigma = kGateMax / kGateSigmas;

// m driven between two searches. Patches that overlap by more share their errors and tell little
// that is new.
constexpr double kQuerySpacing = 0.25;

constexpr int kBefore = 58;  // columns before the query, for the search backwards

constexpr double kLeastRevisitSigma = 0.005;  // m

// changed: of a query in which a change of the ground is undone.
gpr::RevisitSearchOptions search_options(const GraphConfig& config, bool changed);

// The window round the place that lies `ahead_m` (in the direction in which distances rise) of a
// column, within `bound_m`; reach_m: as RevisitSearch says.
gpr::SearchWindow window_on(const gpr::TraceMemory& memory, std::size_t column, double ahead_m,
                            double bound_m, double reach_m);

// The errors of a revisit by its match. moved_m: since the last one in the same run.
RevisitEdge edge_of(const gpr::RevisitMatch& match, double moved_m, const GraphConfig& config);

}  // namespace gprodom
