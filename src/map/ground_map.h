// The ground driven over and where it lies. This is what remains of a track after a reset.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/trace_format.h"
#include "estimation/graph/pose_graph.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom {

// The pose of the robot when its antenna was over a column of the memory.
struct KnownPlace {
  std::size_t column = 0;
  double distance_m = 0.0;  // along its track, as in the memory
  PlanarPose pose;          // of the body, in its map
  int map = 0;              // number of its map; the frames of two maps are not related
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
  // The place of a column (or between two), interpolated from the known places next to it. Nothing
  // if these are further than `reach_m` along the track.
  std::optional<At> at(double column, double reach_m) const;

  // The ground of these columns alone, with its places, in the same maps. The ranges are of stored
  // columns, in ascending order, and do not overlap. Throws std::out_of_range.
  GroundMap part(const std::vector<gpr::MemoryRange>& ranges) const;

  // Whether a place has that map number, and one that none has yet.
  bool holds(int map) const;
  int unused_map() const;
};

}  // namespace gprodom
