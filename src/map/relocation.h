// Where the track lies in the map of an earlier one, or anew on its own ground: a hypothesis, found
// by a search of all ground or told by an operator, until revisits prove it. docs/revisit.md,
// "After a reset".
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/types.h"
#include "map/change_follower.h"
#include "map/ground_store.h"
#include "map/locator.h"
#include "map/map_answer.h"
#include "map/track_graph.h"

namespace gprodom {

// A revisit that was found. Its newer end is placed when it is used.
struct Sighting {
  RevisitEnd memory;
  double column = 0.0;  // of the memory, of that end
  gpr::MemoryColumn query;
  PlanarPose antenna;  // of the newer end, in body
  RevisitEdge edge;
  Displacement told;
};

class Relocation {
 public:
  // A hypothesis that is not proved yet, with all that belongs to it.
  struct Candidate {
    Hypothesis at;
    double from_m = 0.0, until_m = 0.0;  // travelled; it is dropped at until_m
    double told_sigma_m = 0.0;           // 0: it was found, not told
    double next_change_m = 0.0;          // travelled, then the change is supposed again
    std::vector<Sighting> supporting;    // the revisits found for it, in time order
    std::optional<double> supported_m;   // travelled at the first of them
  };

  // Both outlive this.
  Relocation(const GraphConfig& config, const TrackGraph& track, const GroundStore& store);

  // A hypothesis as told, in place of a found one. Only a revisit proves it. Returns true if
  // another place is searched from now on, or ground that has changed in another way.
  bool suppose(const ToldPlace& told, std::vector<std::string>& notes);
  // Searches all ground: that of earlier tracks until the track is located, and where it is lost;
  // its own where it is adrift. Returns true as suppose() does.
  bool locate(std::vector<std::string>& notes);

  const std::optional<Candidate>& candidate() const { return candidate_; }
  // Standard deviation of the position now, in the frame of the candidate if there is one.
  double sigma_m() const;
  // Whether a revisit speaks for the candidate. On own ground: if it is nearer to where the
  // candidate has the robot than to where the track has it.
  bool speaks_for_candidate(const RevisitEnd& memory, const gpr::MemoryColumn& query) const;
  // A revisit of the candidate. Returns the candidate if this proves it: it is none any more.
  std::optional<Candidate> support(const Sighting& seen);

  // How the ground of earlier tracks has changed.
  ChangeFollower& change() { return change_; }

 private:
  bool is_lost() const;
  bool is_adrift() const;
  OwnGround own_ground() const;
  std::optional<GroundMap::At> place_of(double column) const;
  bool may_be(const Hypothesis& found, const PlanarPose& body) const;
  bool suppose_change();
  bool is_proved();

  const double patch_length_m_;
  const TrackGraph& track_;
  const GroundStore& store_;
  std::optional<Candidate> candidate_;
  Locator locator_;
  ChangeFollower change_;
};

}  // namespace gprodom
