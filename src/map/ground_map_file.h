// A ground map as a file, some 5 kB per metre.
#pragma once

#include <string>
#include <string_view>

#include "map/ground_map.h"

namespace gprodom {

// places: in place of the ground's own, of columns that it keeps.
std::string to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places);

// name: of the file, for errors. Throws FileError where the bytes are not a whole ground map, or
// one of another spacing than `options` asks for.
GroundMap ground_map_from(const std::string& name, std::string_view bytes,
                          const gpr::TraceMemoryOptions& options);

}  // namespace gprodom
