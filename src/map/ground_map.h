// The ground driven over and where it lies. This is what remains of a track after a reset.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/trace_format.h"
#include "estimation/graph/pose_graph.h"
#include "gpr/revisit/trace_memory.h"
#include "map/fixes/map_datum.h"

namespace gprodom {

// The pose of the robot when its antenna was over a column of the memory.
struct KnownPlace {
  std::size_t column = 0;
  double distance_m = 0.0;  // along its track, as in the memory
  PlanarPose pose;          // of the body, in its map
  int map = 0;              // number of its map; the frames of two maps are not related
};

// Standard deviations of the odometry along the path of a drive. Where a file does not say, those
// of a robot that shakes on rough ground.
struct PathErrors {
  double position = 0.01;  // m after a metre, by the square root of the distance
  double yaw = 0.003;      // rad, likewise
  double scale = 0.014;    // of the wheel's scale, ln
};

// Of the drive and the antenna that a session of the memory comes from.
struct SessionOrigin {
  Eigen::Vector3d antenna = Eigen::Vector3d::Zero();  // m, in body
  std::string program;
  std::string robot;  // its name; empty: not known
  PathErrors errors;
  int antenna_id = 0;
};

// What the ground of a map comes from: a drive, whose mark is made from the first ground that it
// left, `until` being the time of the last; or a file that was extended, whose mark is its
// identity. Passes are no marks of descent, since they are merged.
struct Ancestor {
  std::uint64_t mark = 0;
  TimeNs until = 0;  // 0: a file
};

// Ground as the bytes of a map file.
struct SavedGround {
  std::string bytes;
  std::vector<Ancestor> descent;  // as in GroundMap; files of version 1 do not hold it
  bool empty = true;              // nothing is stored
  std::uint64_t base = 0;  // the bytes are the newest ground of this file (newest_to_bytes())
};

struct GroundMap {
  explicit GroundMap(const gpr::TraceMemoryOptions& options) : memory(options) {}

  gpr::TraceMemory memory;
  TraceFormat format;  // of the traces in the memory
  std::optional<TraceFormat> known_format() const {
    return format.samples == 0 ? std::nullopt : std::optional(format);
  }
  std::vector<KnownPlace> places;      // in the order of their columns
  std::vector<SessionOrigin> origins;  // of the memory's sessions
  std::map<int, MapDatum> datums;      // of the maps that fixes have tied to site, by their numbers

  // Of the file that this was read from, its identity; 0: it has changed since, or is new. Parents
  // are the identities of the files from which this was made.
  std::uint64_t identity = 0;
  std::vector<std::uint64_t> parents;
  // In the order driven; of files and drives none of whose ground was left out since, but for what
  // lies beside enough other passes.
  std::vector<Ancestor> descent;
  int version = 4;  // of the file
  // Call when ground of a drive was added, from column `first` on, the last of it at `now`. The
  // file that this was read from becomes its parent. new_drive: it is the first of this drive.
  void extended(std::size_t first, TimeNs now, bool new_drive);
  void changes();  // call before it changes in another way

  // The file that it was read from, or that became its parent; 0: none.
  std::uint64_t taken_from() const;
  // Whether this is that file's ground, perhaps extended: then maps have the same numbers. Of files
  // of version 1, which keep no parents, it is taken for granted.
  bool goes_on_from(std::uint64_t file) const;

  // The stored runs, in order.
  std::vector<gpr::MemoryRange> runs() const;

  struct At {
    PlanarPose pose;
    int map = 0;
  };
  // The place of a column (or between two), interpolated from the known places next to it. Nothing
  // if these are further than `reach_m` along the track.
  std::optional<At> at(double column, double reach_m) const;

  // In body: the antenna that saw a column. Files of version 1 do not tell: `unknown`.
  PlanarPose antenna_at(std::size_t column, const PlanarPose& unknown) const;

  // The ground of these columns alone, with its places, in the same maps, and the sessions of it.
  // The ranges are of stored columns, in ascending order, and do not overlap. Throws
  // std::out_of_range.
  GroundMap part(const std::vector<gpr::MemoryRange>& ranges) const;

  // The same as version 1 of the file has it: nothing is learnt anew, and nothing stretched.
  GroundMap features_alone() const;

  // Whether a place has that map number, and one that none has yet.
  bool holds(int map) const;
  int unused_map() const;

 private:
  void restore_features(gpr::MemoryRange piece, gpr::TraceMemory& into) const;
  void restore_sessions(const std::vector<gpr::MemoryRange>& pieces, GroundMap& into) const;
};

}  // namespace gprodom
