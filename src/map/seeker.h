// An antenna that looks for stored ground.
#pragma once

#include <optional>

#include "estimation/planar_geometry.h"
#include "gpr/revisit/revisit_search.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom {

struct Seeker {
  PlanarPose antenna;  // in body
  // Its newest ground, of an antenna abreast of the one whose ground is stored.
  std::optional<gpr::TraceMemory> beside;
  std::optional<gpr::RevisitSearch> search;
  // Ground of earlier tracks may have changed. So it has a search of its own, with a query whose
  // changes are undone; where they can be.
  std::optional<gpr::RevisitSearch> search_before;
  std::optional<gpr::MemoryColumn> last_query;

  void forget() {
    if (search) search->forget();
    if (search_before) search_before->forget();
  }
};

}  // namespace gprodom
