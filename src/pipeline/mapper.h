// The map's part of the pipeline: ground driven over goes into the memory, new ground is looked for
// in it, and what is found ties the track together. Runs in jobs of one worker, off the fast path.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/gpr/revisit_search.h"
#include "gprodom/gpr/trace_memory.h"
#include "gprodom/pose_graph.h"
#include "gprodom/types.h"
#include "pipeline/map_path.h"

namespace gprodom {

struct MapInput {
  std::vector<PathState> states;        // settled, new since the last job
  std::vector<GprTrace> traces;         // not newer than the newest state
  std::vector<Displacement> revisits;   // told by another process
  double scale = 1.0, scale_sigma = 0;  // of the wheel, as believed now
};

// The newest settled state in map.
struct MapPose {
  PlanarEstimate in_map;
  PathState in_odom;
  int revisits = 0;  // that the map rests on
  int refused = 0;   // that it contradicts
};

struct MapAnswer {
  std::optional<MapPose> pose;         // since the first revisit
  std::vector<Displacement> revisits;  // found in this job
  std::vector<std::string> notes;      // why the memory was forgotten, if it was
};

// Between the states at two times.
struct Revisit {
  TimeNs memory = 0, query = 0;
  RevisitEdge edge;  // its places are in the frames of the two states
};

class Mapper {
 public:
  explicit Mapper(const Config& config);

  MapAnswer run(const MapInput& input);

  // Those that the map rests on.
  std::vector<Revisit> revisits() const;

 private:
  void follow(const std::vector<PathState>& states);
  void remember(const GprTrace& trace, MapAnswer& answer);
  void look(MapAnswer& answer);
  std::vector<gpr::SearchWindow> windows(const gpr::MemoryColumn& query) const;
  gpr::SearchWindow window_at(std::size_t node, std::size_t column, double along,
                              double gate) const;
  void tie(const gpr::PlaceFound& found, const gpr::MemoryColumn& query, double moved_m,
           MapAnswer& answer);
  void take_external();
  void solve(double scale, double scale_sigma);
  bool faces(const MapPath::Place& then, const MapPath::Place& now, bool mirrored) const;
  PlanarPose antenna(const PlanarPose& at) const;

  const GraphConfig config_;
  const PlanarPose antenna_;  // in body

  MapPath path_;
  std::optional<PoseGraph> graph_;
  PlanarEstimate newest_node_;
  TimeNs next_solve_ = 0;
  std::vector<bool> trusted_;  // of the graph's revisits, at the last solution

  gpr::TraceMemory memory_;
  std::size_t samples_ = 0;  // of a trace in the memory
  double sample_interval_s_ = 0.0;
  std::optional<gpr::RevisitSearch> search_;
  std::optional<gpr::MemoryColumn> last_query_, last_tied_;
  std::deque<Displacement> external_;  // their end is not settled yet
};

}  // namespace gprodom
