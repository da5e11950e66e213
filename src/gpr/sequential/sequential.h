// The paper's displacement: the B-scan window that ends at a tick is compared with the one that
// ended a step before, and u = -K l* for the shift l* between them (alignment.h; the newest trace
// is on the right).
//
// A moving antenna sees each spot once, and two windows of one stream share all but the newest
// traces. So l* is the number of new traces, whatever the robot did (docs/sfm.md). This front end
// does what the paper describes; trace_count gives the same result without looking at the traces.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "gpr/filter/details_retention.h"
#include "gpr/sequential/window_matcher.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// Of gpr.front_end it serves sfm, bscan, dec, salient and trace_count.
class SequentialFrontEnd : public FrontEnd {
 public:
  explicit SequentialFrontEnd(const GprConfig& config);
  ~SequentialFrontEnd() override;

  void add_trace(const GprTrace& trace) override;

  // At each tick that ends a step, returns one TrackDisplacement over the step. It is not valid if
  // the shift search found no minimum. `score` is 1 less the distance of the two windows at the
  // best shift. Returns nothing until two windows are full.
  std::vector<Finding> tick(TimeNs tick) override;

  void reset() override;

  std::optional<SubsurfaceFeatureMatrix> sfm() const override;

 private:
  TrackDisplacement to_displacement(const Alignment& alignment, TimeNs from, TimeNs to) const;

  GprConfig config_;
  DetailsRetention filter_;
  std::unique_ptr<WindowMatcher> matcher_;
  std::optional<TimeNs> first_trace_, last_trace_, last_step_;
  std::optional<TimeNs> closed_step_;  // the last tick, where it closed a step
  double trace_interval_s_ = 0.0;      // between the last two
};

}  // namespace gprodom::gpr
