// The work of the radar thread at one tick: passes traces to the front end and returns its answer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/trace_format.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"

namespace gprodom {

struct RadarAnswer {
  std::vector<gpr::Finding> findings;
  std::optional<SubsurfaceFeatureMatrix> sfm;  // if the front end makes one and it is asked for
  std::vector<std::string> notes;              // e.g. why the front end was reset
};

class RadarTask {
 public:
  // front_end: replaces config.front_end unless it is empty.
  explicit RadarTask(const GprConfig& config, const gpr::FrontEndFactory& front_end = {});

  bool enabled() const { return front_end_ != nullptr; }

  // traces: those since the last tick, in time order. The front end is reset if a trace has another
  // length or sample interval than the last, or follows a gap.
  RadarAnswer run(const std::vector<GprTrace>& traces, TimeNs tick);

 private:
  std::unique_ptr<gpr::FrontEnd> front_end_;
  TimeNs last_time_ = 0;
  TraceFormat format_;
};

}  // namespace gprodom
