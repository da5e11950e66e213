// A radar front end: traces in, findings about motion out. It knows nothing of states.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gprodom/types.h"

namespace gprodom::gpr {

// The antenna stood from `from` to `to`.
struct Standstill {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;    // the method that says so, for displacement_t.source
  double sigma_m = 0.0;  // motion that may have passed unseen
  double score = 0.0;    // of the method's own
};

// How far the antenna moved, whichever way, in decorrelation lengths of the ground: the front end
// does not know how many metres one of them is. The estimator learns that from wheel and IMU.
struct PathLength {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  bool valid = false;
  double lengths = 0.0;  // above 0
  double score = 0.0;
};

// How far the antenna moved along its track, forwards positive, in metres.
struct TrackDisplacement {
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  bool valid = false;
  double distance_m = 0.0;
  double sigma_m = 0.0;  // standard deviation
  double score = 0.0;
};

// How well a front end that tells Standstill sees motion: from `from` to `to` the antenna moved at
// `times_least` times the slowest speed that its test sees. How many m/s that is, the estimator
// learns from wheel and IMU; a wheel that turns slower is not contradicted by a Standstill.
struct Sight {
  TimeNs from = 0;
  TimeNs to = 0;
  double times_least = 0.0;  // above 0
};

using Finding = std::variant<Standstill, PathLength, TrackDisplacement, Sight>;

// Front ends run on one thread (the GPR thread when live) and are driven by data time alone.
class FrontEnd {
 public:
  virtual ~FrontEnd() = default;

  // One valid trace, in time order. Must be cheap enough for several hundred traces a second.
  virtual void add_trace(const GprTrace& trace) = 0;

  // What can be said at `tick`, given the traces up to it.
  virtual std::vector<Finding> tick(TimeNs tick) = 0;

  // The feature matrix made at the last tick, where the front end makes them, made one then and is
  // asked for them (gpr.sequential.publish_sfm).
  virtual std::optional<SubsurfaceFeatureMatrix> sfm() const { return std::nullopt; }

  // Forgets all traces (after a gap, a reset, a change of trace length or sample interval).
  virtual void reset() = 0;
};

}  // namespace gprodom::gpr
