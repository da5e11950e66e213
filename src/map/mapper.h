// The map's part of the pipeline: ground driven over goes into the memory, new ground is looked for
// in it, and what is found ties the track together, and to the map that a track before a reset has
// left. Runs in jobs of one worker, off the fast path.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "gpr/revisit/revisit_search.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "map/ground_map.h"
#include "map/locator.h"
#include "map/map_path.h"
#include "map/pass_finder.h"
#include "map/pass_merger.h"

namespace gprodom {

// Of the memory that a configuration asks for.
gpr::TraceMemoryOptions memory_options(const Config& config);

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
  int revisits = 0;  // that the map rests on, or rested on when their pass was merged
  int refused = 0;   // that it contradicts
};

struct MapAnswer {
  std::optional<MapPose> pose;         // since the first revisit
  std::vector<Displacement> revisits;  // found in this job
  std::vector<std::string> notes;      // what was forgotten or refused, and why
  bool located = false;                // in this job, on ground from before
  std::optional<int> map;              // of which the track is part
};

// Between the states at two times.
struct Revisit {
  TimeNs memory = 0, query = 0;
  RevisitEdge edge;  // its places are in the frames of the two states
};

// From a time on, up to the next piece.
struct TrackPiece {
  TimeNs from = 0;
  PlanarPose in_odom, in_map;  // of its beginning
  double slip = 0.0;           // ln of the distance in map over that in odom
};

class Mapper {
 public:
  // before: the ground that earlier tracks have left. at: how this track lies on it, where that is
  // known, and how well (covariance of x, y, yaw of the first state).
  struct Start {
    Hypothesis at;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };
  Mapper(const Config& config, std::optional<GroundMap> before, std::optional<Start> start);

  MapAnswer run(const MapInput& input);

  // Keeps all revisits for revisits(), those of merged passes too; before the first run().
  void record() { record_ = true; }

  // Those of this track alone that the map rests on; of merged passes only where recorded.
  std::vector<Revisit> revisits() const;

  // The track of odom as the map has it, in pieces from node to node, in time order.
  std::vector<TrackPiece> track() const;

  // How odom lies in map at the track's beginning.
  PlanarPose map_from_odom() const;

  // The ground of this track and of those before it: handed on, which ends this mapper, or as the
  // bytes of a file.
  GroundMap take_ground();
  std::string ground_bytes() const;

 private:
  // A place as an end of a revisit: of a node, or kInMap.
  struct End {
    std::size_t node = 0;
    PlanarPose body;   // in the node's frame, or in map
    double yaw = 0.0;  // of the body, in map
    WheelWay way;      // of `body`
  };

  void follow(const std::vector<PathState>& states);
  void remember(const GprTrace& trace, MapAnswer& answer);
  void look(MapAnswer& answer);
  void locate();
  void settle_in(const Hypothesis& at);
  std::vector<gpr::SearchWindow> windows(const gpr::MemoryColumn& query) const;
  gpr::SearchWindow window_at(const Pass& pass, const gpr::MemoryColumn& query, double gate) const;
  void foretell_stretch(const Pass& pass, const gpr::MemoryColumn& query,
                        gpr::SearchWindow& window) const;
  PlanarPose body_at(const MapPath::Place& place) const;
  void tie(const gpr::PlaceFound& found, const gpr::MemoryColumn& query, double moved_m,
           MapAnswer& answer);
  std::optional<End> remembered_end(double column) const;
  End end_at(const MapPath::Place& place) const;
  bool add_edge(const End& memory, const End& query, RevisitEdge edge);
  void take_external(MapAnswer& answer);
  void solve(double scale, double scale_sigma, MapAnswer& answer);
  void merge();
  Revisit told(std::size_t revisit) const;
  std::optional<std::size_t> column_at(std::size_t node) const;
  std::vector<KnownPlace> places() const;

  const GraphConfig config_;
  const SlipModel slip_;
  const PlanarPose antenna_;  // in body

  MapPath path_;
  std::optional<PoseGraph> graph_;
  PlanarEstimate newest_node_;
  TimeNs next_solve_ = 0, solve_anyway_ = 0;
  std::vector<bool> trusted_;  // of the graph's revisits, at the last solution
  PassMerger merger_;
  double next_merge_m_ = 0.0;                    // travelled
  int merged_trusted_ = 0, merged_refused_ = 0;  // revisits of passes that were merged
  bool record_ = false;
  std::vector<Revisit> merged_;  // where recorded

  GroundMap ground_;                      // its places are those of tracks before
  std::size_t end_of_before_ = 0;         // columns of this track come from here on
  std::optional<Start> start_;            // until there is a state
  int map_ = 0;                           // of this track
  bool located_ = false;                  // on ground from before: map is its frame
  std::optional<Hypothesis> hypothesis_;  // not confirmed yet
  double hypothesis_until_m_ = 0.0;       // travelled
  Locator locator_;
  std::optional<gpr::RevisitSearch> search_;
  std::optional<gpr::MemoryColumn> last_query_;
  std::deque<Displacement> external_;  // their end is not settled yet
};

}  // namespace gprodom
