// The outputs of the estimator: plain values, to be published.
#pragma once

#include <string>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

// What one step produced, each list in time order.
struct Outputs {
  std::vector<OdometryEstimate> odometry;         // one per accepted IMU sample, in `odom`
  std::vector<OdometryEstimate> odometry_in_map;  // the same poses in `map`
  std::vector<Displacement> displacements;        // from the radar front end and the trace memory
  std::vector<Correction> corrections;  // map -> odom, twice a second from the first revisit on
  std::vector<SubsurfaceFeatureMatrix> sfm;  // if the front end makes them and is asked to
  std::vector<Status> status;                // once per second of data time
  std::vector<std::string> warnings;         // rate-limited, ready to be logged
  bool restarted = false;  // the clock was set: `odom` starts again at the initialiser
};

}  // namespace gprodom
