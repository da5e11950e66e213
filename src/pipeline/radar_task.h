// One tick's work of the radar thread: traces to the front end, its answer back.
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
  std::optional<SubsurfaceFeatureMatrix> sfm;  // where the front end made one and is asked for it
  std::vector<std::string> notes;              // why the front end started afresh, if it did
};

class RadarTask {
 public:
  // front_end: in place of config.front_end; empty: that one.
  explicit RadarTask(const GprConfig& config, const gpr::FrontEndFactory& front_end = {});

  bool enabled() const { return front_end_ != nullptr; }

  // traces: those since the last tick, in time order. Traces of another length or sample interval
  // than the last, or after a gap, start the front end afresh.
  RadarAnswer run(const std::vector<GprTrace>& traces, TimeNs tick);

 private:
  TimeNs max_gap_;
  std::unique_ptr<gpr::FrontEnd> front_end_;
  TimeNs last_time_ = 0;
  TraceFormat format_;
};

}  // namespace gprodom
