// The paper's displacement: the B-scan window that ends at a tick against the one that ended a step
// before, u = -K l* for the shift l* between them (alignment.h; the newest trace is on the right).
//
// One antenna that moves on sees each spot once, and two windows of one stream share all but the
// newest traces: l* counts these, whatever the robot did (docs/sfm.md). The front end is what the
// paper describes, and trace_count says the same without looking.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "gpr/filter/details_retention.h"
#include "gpr/sequential/window_matcher.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// Of gpr.front_end it serves sfm, bscan, dec and trace_count.
class SequentialFrontEnd : public FrontEnd {
 public:
  explicit SequentialFrontEnd(const GprConfig& config);
  ~SequentialFrontEnd() override;

  void add_trace(const GprTrace& trace) override;

  // At every tick that closes a step one TrackDisplacement from the step's begin to the tick; not
  // valid where the shift search found no minimum. `score` is 1 less the distance of the two
  // windows at the best shift. Nothing until two windows are full.
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
