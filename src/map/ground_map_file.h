// A ground map as a file, at most 6 kB per metre: docs/map_format.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "map/ground_map.h"

namespace gprodom {

// places: written instead of the ground's own; their columns are stored in it.
std::string to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places);

// A long map is written seldom. What was added to it since goes into a second file, NAME.new beside
// NAME.map: the columns behind those that the whole file has, and all places of the drive.
struct SavedColumns {
  std::uint64_t identity = 0;      // of the whole file
  std::size_t first = 0, end = 0;  // columns of the memory that it holds and that do not change
};
std::string newest_to_bytes(const GroundMap& ground, const std::vector<KnownPlace>& places,
                            std::size_t first_of_drive, const SavedColumns& saved);
// The identity of the file that it belongs to. Throws FileError.
std::uint64_t base_of_newest(const std::string& name, std::string_view bytes);
std::string newest_of(const std::string& path);

// What tells one file from another, without its ground.
struct GroundHead {
  std::uint64_t identity = 0;
  TraceFormat format;
  bool has_ground = false;
  std::vector<Ancestor> descent;  // as in GroundMap; version 4 and later
};

// Throws FileError if the bytes are not complete, or of a version that this program does not know.
GroundHead ground_head(const std::string& name, std::string_view bytes);

// Whether the ground has all that the file has: every drive of the file at least as far, or the
// file itself, extended.
bool descends(const GroundHead& ground, const GroundHead& file);

// name: of the file, for errors. Throws FileError if the bytes are not a complete ground map, or if
// its spacing is not that of `options`.
GroundMap ground_map_from(const std::string& name, std::string_view bytes,
                          const gpr::TraceMemoryOptions& options);

// A file with its newest ground, if there is any; nothing if there is no file. Newest ground that
// cannot be used is left out with a notice. Throws FileError.
std::optional<GroundMap> read_ground_map(const std::string& path,
                                         const gpr::TraceMemoryOptions& options,
                                         std::vector<std::string>& notices);

}  // namespace gprodom
