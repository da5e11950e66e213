// A radar front end: traces in, displacement measurements out. It knows nothing of states.
#pragma once

#include <optional>
#include <vector>

#include "gprodom/types.h"

namespace gprodom::gpr {

// Front ends run on one thread (the GPR thread when live) and are driven by data time alone.
class FrontEnd {
 public:
  virtual ~FrontEnd() = default;

  // One valid trace, in time order. Must be cheap enough for several hundred traces a second.
  virtual void add_trace(const GprTrace& trace) = 0;

  // What can be said at `tick`, given the traces up to it. `time` of each result is left to the
  // caller.
  virtual std::vector<Displacement> tick(TimeNs tick) = 0;

  // The feature matrix made at the last tick, where the front end makes them, made one then and is
  // asked for them (gpr.sequential.publish_sfm).
  virtual std::optional<SubsurfaceFeatureMatrix> sfm() const { return std::nullopt; }

  // Forgets all traces (after a gap, a reset, a change of trace length or sample interval).
  virtual void reset() = 0;
};

}  // namespace gprodom::gpr
