// The ground driven over and where it lies: what of a track outlasts a reset.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/trace_format.h"
#include "estimation/graph/pose_graph.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom {

// Where the robot was when its antenna was over a column of the memory.
struct KnownPlace {
  std::size_t column = 0;
  double distance_m = 0.0;  // along its track, as the memory has it
  PlanarPose pose;          // of the body, in its map
  int map = 0;              // places of one map are in one frame; how two maps lie is not known
};

struct GroundMap {
  explicit GroundMap(const gpr::TraceMemoryOptions& options) : memory(options) {}

  gpr::TraceMemory memory;
  TraceFormat format;              // of the traces in the memory
  std::vector<KnownPlace> places;  // in the order of their columns

  struct At {
    PlanarPose pose;
    int map = 0;
  };
  // Of a column, which may lie between two, by the known places next to it; nothing where all of
  // those are further than `reach_m` along the track.
  std::optional<At> at(double column, double reach_m) const;

  // A number that no place has.
  int unused_map() const;
};

}  // namespace gprodom
