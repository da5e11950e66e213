// What goes into a job of the map, and what comes out.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "gprodom/config.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"
#include "map/fixes/fix_judge.h"
#include "map/path/map_path.h"

namespace gprodom {

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

}  // namespace gprodom
