// A ground map as a file, at most 6 kB per metre: docs/map_format.md.
#pragma once

#include <string>
#include <string_view>

#include "map/ground_map.h"

namespace gprodom {

// places: written instead of the ground's own; their columns are stored in it.
std::string to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places);

// name: of the file, for errors. Throws FileError if the bytes are not a complete ground map, or if
// its spacing is not that of `options`.
GroundMap ground_map_from(const std::string& name, std::string_view bytes,
                          const gpr::TraceMemoryOptions& options);

}  // namespace gprodom
