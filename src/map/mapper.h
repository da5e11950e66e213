// SLAM back end. It stores the ground driven over, searches it for the newest ground, and adds each
// revisit found (loop closure) to the pose graph of the track. After a reset, a revisit on older
// ground ties the track to the map of an earlier track. Runs in jobs of one worker thread.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "gprodom/config.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"
#include "map/change_follower.h"
#include "map/fixes/fix_keeper.h"
#include "map/ground_map.h"
#include "map/ground_map_file.h"
#include "map/locator.h"
#include "map/pass_finder.h"
#include "map/pass_merger.h"
#include "map/path/map_path.h"
#include "map/seeker.h"

namespace gprodom {

// Ground is looked for within three standard deviations of the position. The least is what a
// covariance that is too small must not hide; the most bounds the cost of a search, and the places
// that could match by chance.
constexpr double kGateSigmas = 3.0;
constexpr double kGateMin = 0.6, kGateMax = 5.0;  // m

// Options of the memory, from the configuration.
gpr::TraceMemoryOptions memory_options(const Config& config);

// A place as told by an operator.
struct ToldPlace {
  RoughPlace place;
  PlanarPose in_odom;  // of the robot when it was told
};

struct MapInput {
  std::vector<PathState> states;        // settled states since the last job
  std::vector<GprTrace> traces;         // up to the newest state
  std::vector<GprTrace> beside;         // likewise, of antennas abreast, as the first has them
  std::vector<Displacement> revisits;   // from another process
  std::vector<PositionFix> fixes;       // since the last job
  std::optional<ToldPlace> told;        // since the last job
  double scale = 1.0, scale_sigma = 0;  // of the wheel, as estimated now
};

// The newest settled state in map.
struct MapPose {
  PlanarEstimate in_map;
  PathState in_odom;
  int revisits = 0;  // trusted by the last solution, or when their pass was merged
  int refused = 0;   // left out by it
};

struct FixReport {
  std::size_t used = 0, refused = 0;  // now; none is used before map is site
  std::optional<Geodetic> datum;      // of site, where it is known
  // Of the wheel's scale, by the last solution with them; sigma 0: none yet.
  double scale = 1.0, scale_sigma = 0.0;
  FixTrouble trouble = FixTrouble::kNone;
};

struct MapAnswer {
  std::optional<MapPose> pose;         // from the first revisit on
  std::vector<Displacement> revisits;  // found in this job
  std::vector<std::string> notes;      // what was dropped or refused, and why
  bool located = false;                // this job has tied the track to an earlier map
  std::optional<FixReport> fixes;      // from the first fix on
  bool tied = false;                   // this job has turned map into site
  std::optional<int> map;              // number of the map that the track belongs to
  double travelled_m = 0.0;            // of the track
  double sigma_m = 0.0;                // standard deviation of the newest position in map
};

// A revisit between the states at two times.
struct Revisit {
  TimeNs memory = 0, query = 0;
  RevisitEdge edge;  // its places are in the frames of the two states
};

// A fix that the solution uses.
struct UsedFix {
  TimeNs time = 0;
  FixEdge edge;  // without its place at a node
  int antenna = 0;
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  // of the antenna in body
  double arm_sigma = 0.0;                               // Anchor
};

// A piece of the track: from its time to that of the next piece.
struct TrackPiece {
  TimeNs from = 0;
  PlanarPose in_odom, in_map;  // of its beginning
  // ln of the distance in map over that in odom; none where antennas in a row have measured it.
  std::optional<double> slip;
};

class Mapper {
 public:
  // before: the ground of earlier tracks. start: how this track lies in its map, if that is known,
  // and how surely: the covariance (x, y, yaw, map axes) of the pose of a state before the first
  // one. What the odometry has lost from there to the first one is added.
  struct Start {
    Hypothesis at;
    PathState since;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };
  Mapper(const Config& config, std::optional<GroundMap> before, std::optional<Start> start);

  MapAnswer run(const MapInput& input);

  // Call before the first run(): keeps all revisits for revisits(), also those of merged passes.
  void record() { record_ = true; }

  // The trusted revisits of this track with itself; those of merged passes only if recorded.
  std::vector<Revisit> revisits() const;

  // To site, which is `map` since.
  bool is_tied() const { return tied_; }

  // Of this track, in time order; none before they have tied it to site.
  std::vector<UsedFix> used_fixes() const;

  // How the map deforms the track of odom: a piece for each node, in time order.
  std::vector<TrackPiece> track() const;

  // Of all solutions of the pose graph so far (NormalMatrix::work()).
  double solve_work() const { return solve_work_; }

  // How odom lies in map at the track's beginning.
  PlanarPose map_from_odom() const;

  // The ground of this track and of earlier ones. Taking it ends this mapper.
  GroundMap take_ground();
  // That of earlier tracks alone.
  GroundMap take_earlier_ground();
  // main: newest_ground() goes on from it.
  SavedGround saved_ground(bool main);
  // What was stored since the main file was saved, or since the file that the ground was read from;
  // all of it where there is no such file. No bytes where nothing was stored since the last call,
  // nor of ground of version 1.
  SavedGround newest_ground();

 private:
  // One end of a revisit: near a node, or fixed in map (kInMap).
  struct End {
    std::size_t node = 0;
    PlanarPose body;     // in the node's frame, or in map
    double yaw = 0.0;    // of the body, in map
    WheelWay way;        // the part of `body` that the wheel measured
    PlanarPose antenna;  // in body
  };

  // A revisit found by this mapper. Its newer end is placed when it is used.
  struct Sighting {
    End memory;
    double column = 0.0;  // of the memory, of that end
    gpr::MemoryColumn query;
    PlanarPose antenna;  // of the newer end, in body
    RevisitEdge edge;
    Displacement told;
  };

  // A hypothesis that is not proved yet, with all that belongs to it.
  struct Candidate {
    Hypothesis at;
    double from_m = 0.0, until_m = 0.0;  // travelled; it is dropped at until_m
    double told_sigma_m = 0.0;           // 0: it was found, not told
    double next_change_m = 0.0;          // travelled, then the change is supposed again
    std::vector<Sighting> supporting;    // the revisits found for it, in time order
    std::optional<double> supported_m;   // travelled at the first of them
  };

  void follow(const std::vector<PathState>& states);
  void begin_graph(const PathState& first);
  void remember(const GprTrace& trace, MapAnswer& answer);
  void follow_antenna(int antenna_id);
  void note_origin();
  void note_errors(double scale_sigma);
  void look_beside(const GprTrace& trace, MapAnswer& answer);
  void search_memory(Seeker& seeker, MapAnswer& answer);
  void forget_searches();
  const gpr::TraceMemory& newest_of(const Seeker& seeker) const {
    return seeker.beside ? *seeker.beside : ground_.memory;
  }
  void begin_searches(Seeker& seeker) const;
  void find_in(Seeker& seeker, bool before, double moved,
               const std::vector<gpr::SearchWindow>& windows, MapAnswer& answer);
  void locate(MapAnswer& answer);
  bool is_lost() const;
  bool is_adrift() const;
  OwnGround own_ground() const;
  std::optional<GroundMap::At> place_of(double column) const;
  bool may_be(const Hypothesis& found, const PlanarPose& body) const;
  void suppose(const ToldPlace& told, MapAnswer& answer);
  void suppose_change();
  double sigma_m() const;
  bool is_proved();  // the candidate, by a revisit now
  void join_map(const Hypothesis& at);
  // How far a query may lie from its pose, along the track and aside.
  struct Reach {
    double gate_m, aside_m;
  };
  std::vector<Pass> own_passes(const PlanarPose& here, const Reach& reach, double query_begins,
                               const gpr::MemoryColumn& query) const;
  std::vector<Pass> passes_of_before(const PlanarPose& here, int map, const Reach& reach,
                                     const Seeker& seeker) const;
  std::vector<gpr::SearchWindow> windows(const Seeker& seeker, const gpr::MemoryColumn& query);
  gpr::SearchWindow window_at(const Seeker& seeker, const Pass& pass,
                              const gpr::MemoryColumn& query, double gate) const;
  void predict_stretch(const Seeker& seeker, const Pass& pass, const gpr::MemoryColumn& query,
                       gpr::SearchWindow& window) const;
  PlanarPose body_at(const MapPath::Place& place) const;
  PlanarPose antenna_at(std::size_t node) const;
  Sighting sighting(const Seeker& seeker, const End& memory, const gpr::MemoryColumn& then,
                    const gpr::MemoryColumn& query, const gpr::RevisitMatch& match,
                    double moved_m) const;
  bool support(const Sighting& seen, MapAnswer& answer);
  bool use(const Sighting& seen, MapAnswer& answer);
  bool is_of_candidate(const End& memory, const gpr::MemoryColumn& query) const;
  void tie(const Seeker& seeker, const gpr::PlaceFound& found, const gpr::MemoryColumn& query,
           double moved_m, MapAnswer& answer);
  void mark_known(const gpr::MemoryColumn& query);
  std::optional<End> remembered_end(double column) const;
  End end_at(const MapPath::Place& place, const PlanarPose& antenna) const;
  bool add_edge(const End& memory, const End& query, RevisitEdge edge);
  void take_external(MapAnswer& answer);
  void take_fixes(const MapInput& input, MapAnswer& answer);
  void place_fixes();
  FixReport fix_report() const;
  struct SiteTie {
    PlanarPose by;                  // moves what is in map to site
    Eigen::Matrix3d first;          // covariance of the first node there, beside the fixes
    std::optional<MapDatum> datum;  // of the ground that the track lies on, if that tells `by`
  };
  void take_datums();
  void note_datum();
  std::vector<PlanarPose> places_of_fixes(const PlanarPose& site_from_map) const;
  std::optional<SiteTie> tie_by_ground() const;
  std::optional<SiteTie> tie_by_fixes() const;
  void tie_to_site(const MapInput& input, MapAnswer& answer);
  void move_ground(int map, const PlanarPose& by);
  void move_newest(const PlanarPose& by);
  void solve(double scale, double scale_sigma, MapAnswer& answer);
  void solve_newest(MapAnswer& answer);
  void note_tie(std::size_t revisit);
  void merge();
  Revisit told(std::size_t revisit) const;
  std::optional<std::size_t> column_at(std::size_t node) const;
  std::vector<KnownPlace> places() const;

  const GraphConfig config_;
  const SlipModel slip_;
  const Antennas antennas_;
  const Eigen::Vector3d lever_arm_;  // of an antenna that is not among them
  double longest_arm_m_;             // of an antenna now or of the ground's

  MapPath path_;
  std::optional<PoseGraph> graph_;
  PlanarEstimate newest_node_;
  TimeNs next_solve_ = 0, solve_anyway_ = 0, next_newest_ = 0;
  double solved_to_m_ = 0.0;  // travelled at the newest node of the last solution
  Eigen::Matrix3d solved_to_covariance_ = Eigen::Matrix3d::Zero();  // of its pose
  double solve_work_ = 0.0;
  double fresh_at_m_ =
      0.0;  // travelled; from here on the graph has a new node since the last solution
  std::vector<bool> trusted_;        // of the graph's revisits, at the last solution
  std::optional<double> tied_at_m_;  // travelled at the newest trusted revisit
  double tied_variance_m2_ = 0.0;    // of the position in map, when that was found
  PassMerger merger_;
  double next_merge_m_ = 0.0;                    // travelled
  int merged_trusted_ = 0, merged_refused_ = 0;  // revisits of passes that were merged
  bool record_ = false;
  std::vector<Revisit> merged_;  // where recorded

  GroundMap ground_;      // its places are those of earlier tracks
  SessionOrigin origin_;  // of this track
  Eigen::Vector3d step_variances_ = Eigen::Vector3d::Zero();  // sums: m, m^2, rad^2
  std::size_t end_of_before_ = 0;  // number of the first column of this track
  std::size_t first_session_ = 0;  // of this track
  std::size_t noted_end_ = 0;      // of its stored ground, when its origin was noted; 0: none yet
  TimeNs last_trace_ = 0;
  std::optional<SavedColumns> saved_;  // in the last whole file
  std::size_t saved_end_ = 0;          // of the stored ground, in any file
  std::optional<Start> start_;         // until there is a state
  // Of (x, y, yaw) of the first node in its map, where the track started there.
  std::optional<Eigen::Matrix3d> start_covariance_;
  int map_ = 0;           // number of this track's map
  bool located_ = false;  // tied to an earlier map, whose frame is `map`
  bool moved_ = false;    // to a map, at the start or since
  FixKeeper fixes_;
  std::deque<PositionFix> waiting_fixes_;  // for settled states, in time order
  bool fixes_changed_ = false;             // since the last solution
  bool solved_in_site_ = false;
  bool tied_ = false;         // to site, which is `map` since
  bool keeps_datum_ = false;  // tied by that of the ground, which stays what it was
  std::optional<Candidate> candidate_;
  Locator locator_;
  Seeker seeker_;                  // the antenna whose ground is stored
  std::map<int, Seeker> abreast_;  // others, by their ids
  ChangeFollower change_;
  bool crowded_ = false;  // at the last query: passes are stored side by side, and one more is none
  std::deque<Displacement> external_;  // revisits of another process, to wait for settled states
};

}  // namespace gprodom
