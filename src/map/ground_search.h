// Searches the stored ground for the newest, where the robot may be by its pose and by the
// candidate of the relocation. docs/revisit.md.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "gpr/revisit/revisit_search.h"
#include "gpr/revisit/trace_memory.h"
#include "gprodom/config.h"
#include "gprodom/types.h"
#include "map/ground_store.h"
#include "map/pass_finder.h"
#include "map/relocation.h"
#include "map/track_graph.h"

namespace gprodom {

// An antenna that looks for stored ground.
struct Seeker {
  PlanarPose antenna;  // in body
  // Its newest ground, of an antenna abreast of the one whose ground is stored.
  std::optional<gpr::TraceMemory> beside;
  std::optional<gpr::RevisitSearch> search;
  // Ground of earlier tracks may have changed. So it has a search of its own, with a query whose
  // changes are undone; where they can be.
  std::optional<gpr::RevisitSearch> search_before;
  std::optional<gpr::MemoryColumn> last_query;

  void forget() {
    if (search) search->forget();
    if (search_before) search_before->forget();
  }
};

class GroundSearch {
 public:
  // All three outlive this.
  GroundSearch(const GraphConfig& config, const TrackGraph& track, GroundStore& store,
               Relocation& relocation);

  // A place that was found. moved_m: since the last search in the same run.
  struct Found {
    const Seeker& seeker;
    const gpr::PlaceFound& place;
    const gpr::MemoryColumn& query;
    double moved_m;
  };
  using Take = std::function<void(const Found&)>;

  // After each trace that was stored: every kQuerySpacing, searches for the newest ground.
  void look(const Take& take) { search(seeker_, take); }
  // The same for a trace of an antenna abreast of the one whose ground is stored.
  void look_beside(const GprTrace& trace, const Take& take);

  void follow_antenna();  // the antenna whose ground is stored is another one now
  void forget();          // what was found nearby; another place is searched from now on

 private:
  // How far a query may lie from its pose, along the track and aside.
  struct Reach {
    double gate_m, aside_m;
  };
  const gpr::TraceMemory& newest_of(const Seeker& seeker) const {
    return seeker.beside ? *seeker.beside : store_.memory();
  }
  void begin(Seeker& seeker) const;
  void search(Seeker& seeker, const Take& take);
  void find_in(Seeker& seeker, bool before, double moved_m,
               const std::vector<gpr::SearchWindow>& windows, const Take& take);
  std::vector<Pass> own_passes(const PlanarPose& here, const Reach& reach, double query_begins,
                               const gpr::MemoryColumn& query) const;
  std::vector<Pass> passes_of_before(const PlanarPose& here, int map, const Reach& reach,
                                     const Seeker& seeker) const;
  std::vector<gpr::SearchWindow> windows(const Seeker& seeker, const gpr::MemoryColumn& query);
  gpr::SearchWindow window_at(const Seeker& seeker, const Pass& pass,
                              const gpr::MemoryColumn& query, double gate_m) const;
  void predict_stretch(const Seeker& seeker, const Pass& pass, const gpr::MemoryColumn& query,
                       gpr::SearchWindow& window) const;

  const GraphConfig config_;
  const TrackGraph& track_;
  GroundStore& store_;
  Relocation& relocation_;
  Seeker seeker_;                  // the antenna whose ground is stored
  std::map<int, Seeker> abreast_;  // others, by their ids
  bool crowded_ = false;  // at the last query: passes are stored side by side, and one more is none
};

}  // namespace gprodom
