// Relocalisation, after a reset or where the track is lost. Every few metres, all stored ground is
// searched (gpr/global_search.h) for the newest ground. A place found is a hypothesis of how the
// track lies in the map, until revisits prove it. docs/revisit.md, "After a reset".
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "gpr/revisit/global_search.h"
#include "map/ground_map.h"

namespace gprodom {

// A hypothesis of how the track lies in a map.
struct Hypothesis {
  PlanarPose map_from_track;
  int map = 0;
  gpr::TraceChange change;  // of the ground now since the map
  bool own = false;         // on ground of this track: the track is off by `map_from_track` now
};

// Ground of the track itself that is searched, too.
struct OwnGround {
  std::size_t end = 0;  // number of the column after its last one; 0: none
  std::function<std::optional<GroundMap::At>(double column)> place;  // where it lies
};

class Locator {
 public:
  Locator();

  // Whether a search is due after this distance.
  bool is_due(double travelled_m) const { return travelled_m >= next_m_; }

  // The last column that a search of the newest ground takes: what was driven since then proves a
  // place found. Nothing while too little is driven.
  static std::optional<gpr::MemoryColumn> last_searched(const gpr::TraceMemory& memory,
                                                        std::size_t end_of_before);

  // Compares the newest ground (columns from `end_of_before` on) with all ground before that
  // column, and with `own`. newest_body: pose of the robot in the track's frame at last_searched().
  // antenna: in body, that of the newest ground.
  std::optional<Hypothesis> find(const GroundMap& ground, std::size_t end_of_before,
                                 const PlanarPose& newest_body, const PlanarPose& antenna,
                                 double travelled_m, const OwnGround& own = {});

  // The same for the last metres of `driven`, columns of one run of the ground. body: pose of the
  // robot at the last of them.
  std::optional<Hypothesis> place(const GroundMap& ground, std::size_t end_of_before,
                                  gpr::MemoryRange driven, const PlanarPose& body);

  // Round a place of a map.
  struct Near {
    int map = 0;
    Eigen::Vector2d at;
    double within_m = 0.0;
  };
  // Of the changes that place() tries, the one that fits the newest ground best near a place,
  // however well; nothing while too little is driven, or where no ground is near.
  static std::optional<gpr::TraceChange> change_near(const GroundMap& ground,
                                                     std::size_t end_of_before, const Near& near);

  // m of ground that place() wants at least.
  static double least_query();

 private:
  // Ground that is looked for.
  struct Driven {
    std::size_t columns = 0;
    std::function<gpr::Columns(const gpr::TraceChange&)> without;  // features of the last columns
    int direction = 1;
    PlanarPose body;     // at the last column
    PlanarPose antenna;  // in body
  };
  static Driven newest(const GroundMap& ground, std::size_t end_of_before);
  static std::vector<gpr::GlobalQuery> queries(const Driven& driven, bool can_undo,
                                               const std::vector<double>& stretches);
  std::optional<Hypothesis> place(const GroundMap& ground, std::size_t end_of_before,
                                  const Driven& driven, const std::vector<double>& stretches,
                                  const OwnGround& own = {});
  void learn(const GroundMap& ground, std::size_t end);

  double next_m_;
  bool likely_ = true;       // the likely stretches are tried next
  std::size_t learned_ = 0;  // the columns before it are in search_
  std::optional<gpr::GlobalSearch> search_;
};

}  // namespace gprodom
