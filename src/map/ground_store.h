// The ground that a track stores, with that of earlier tracks: what of it is kept, where it lies in
// its maps, and what goes into a map file.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"
#include "map/ground_map.h"
#include "map/ground_map_file.h"
#include "map/track_graph.h"

namespace gprodom {

// Options of the memory, from the configuration.
gpr::TraceMemoryOptions memory_options(const Config& config);

class GroundStore {
 public:
  // before: the ground of earlier tracks.
  GroundStore(const Config& config, std::optional<GroundMap> before);

  const GroundMap& ground() const { return ground_; }
  const gpr::TraceMemory& memory() const { return ground_.memory; }
  std::size_t end_of_before() const { return end_of_before_; }  // number of the own first column

  // The antenna whose ground is stored, in body.
  PlanarPose antenna() const { return {origin_.antenna.head<2>(), 0.0}; }
  // That of ground whose antenna is not told, and of revisits of other processes.
  PlanarPose default_antenna() const { return {lever_arm_.head<2>(), 0.0}; }
  // That of an id; nothing where it is not configured.
  std::optional<PlanarPose> antenna(int id) const;
  // No antenna, now or of earlier ground, is further from the body's origin.
  double longest_arm_m() const { return longest_arm_m_; }

  // Number of this track's map. Located: it is that of an earlier track.
  int map() const { return map_; }
  bool located() const { return located_; }
  // begins: before the first trace. Where the ground of that map was never written, it is its own.
  void locate_in(int map, bool begins = false);
  // Earlier ground of a map, as a whole.
  void move_places(int map, const PlanarPose& by);
  std::map<int, MapDatum>& datums() { return ground_.datums; }

  // Stores a trace. Returns true if it is of another antenna than the one before, elsewhere on the
  // body: its ground is a session of its own.
  bool remember(const GprTrace& trace, const MapPath& path, std::vector<std::string>& notes);
  // The ground of a query is not stored once more. But a track that is not located yet keeps all
  // its ground, since the search in earlier ground needs it whole.
  void mark_known(const gpr::MemoryColumn& query, double travelled_m);
  void note_errors(const PathErrors& errors) { origin_.errors = errors; }

  // The memory's column at a node of this track; nothing if none is stored there.
  std::optional<std::size_t> column_at(const MapPath& path, std::size_t node) const;
  // In body: the antenna that saw the ground there.
  PlanarPose antenna_at(const MapPath& path, std::size_t node) const;
  // The robot when it stored a column, or saw it on an earlier track; nothing where it is not kept.
  std::optional<RevisitEnd> end_at(double column, const TrackGraph& track) const;

  // main: newest() goes on from it.
  SavedGround saved(const TrackGraph& track, bool main);
  // What was stored since the main file was saved, or since the file that the ground was read from;
  // all of it where there is no such file. No bytes where nothing was stored since the last call,
  // nor of ground of version 1.
  SavedGround newest(const TrackGraph& track);
  // The ground of this track and of earlier ones, or of these alone. Taking it ends this.
  GroundMap take(const TrackGraph& track);
  GroundMap take_earlier(const TrackGraph& track);

 private:
  bool follow_antenna(int antenna_id);
  void note_origin();
  std::vector<KnownPlace> places(const TrackGraph& track) const;

  const Antennas antennas_;
  const Eigen::Vector3d lever_arm_;  // of an antenna that is not among them
  const double patch_length_m_;
  double longest_arm_m_;

  GroundMap ground_;               // its places are those of earlier tracks
  SessionOrigin origin_;           // of this track
  std::size_t end_of_before_ = 0;  // number of the first column of this track
  std::size_t first_session_ = 0;  // of this track
  std::size_t noted_end_ = 0;      // of its stored ground, when its origin was noted; 0: none yet
  TimeNs last_trace_ = 0;
  int map_ = 0;
  bool located_ = false;
  std::optional<SavedColumns> saved_;  // in the last whole file
  std::size_t saved_end_ = 0;          // of the stored ground, in any file
};

}  // namespace gprodom
