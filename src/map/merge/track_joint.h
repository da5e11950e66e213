// One attempt to tie two tracks, begun with a hypothesis of how one lies on the other.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "map/merge/map_joiner.h"

namespace gprodom {

class TrackJoint {
 public:
  // joining: of the track that joins, its map's number and its stored runs. at: the hypothesis, by
  // the place of column `seen`.
  TrackJoint(const GroundMap& ground, int joining, std::vector<gpr::MemoryRange> runs,
             const Hypothesis& at, std::size_t seen, const GraphConfig& config);

  // Searches the runs for ground of the other track, as far as the poses tell where. first: column
  // with which it begins. give_up_m: it ends when so much was driven without finding any.
  void sweep(std::size_t first = 0, double give_up_m = std::numeric_limits<double>::infinity());

  JoinedTracks result();

 private:
  struct Track {
    std::vector<KnownPlace> places;
    std::size_t node = 0;  // of the first place in the graph
  };
  struct Tie {
    std::size_t column = 0;
    Eigen::Vector2d at;  // of the column, in the joining track's own frame
  };

  Track track_of(int map) const;
  const PathErrors& errors_at(std::size_t column) const;
  double scale_sigma(const Track& track) const;
  void add_track(const Track& track, double scale_share);
  void search_run(gpr::MemoryRange run, std::size_t first, double give_up_m);
  bool search_at(gpr::MemoryRange run, std::size_t end, double moved_m);
  std::vector<gpr::SearchWindow> windows(const gpr::MemoryColumn& query, const PlanarPose& here,
                                         double gate_m) const;
  bool tie(const gpr::PlaceFound& found, std::size_t query, double moved_m);
  struct End {
    std::size_t node = 0;
    PlanarPose at;  // in its frame
    PlanarPose now;
  };
  std::optional<End> end_at(const Track& track, double column) const;
  double sigma_at(const Eigen::Vector2d& own) const;
  void solve();

  const GroundMap& ground_;
  const GraphConfig config_;
  const std::vector<gpr::MemoryRange> runs_;
  Track there_, here_;
  double ratio_sigma_ = 0.0;  // of the wheel's scale in one map over that in the other, ln
  std::optional<PoseGraph> graph_;
  gpr::RevisitSearch search_;
  ChangeFollower change_;
  std::vector<Tie> ties_;  // of the graph's revisits
  Eigen::Vector2d seen_;   // where the hypothesis was found, in the joining track's own frame
  std::optional<PoseGraphSolution> solution_;
  double since_solved_m_ = 0.0, since_found_m_ = 0.0;
};

}  // namespace gprodom
