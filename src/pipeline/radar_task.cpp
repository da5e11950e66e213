#include "pipeline/radar_task.h"

#include <cmath>

#include "gpr/front_end_factory.h"

namespace gprodom {

RadarTask::RadarTask(const GprConfig& config)
    : max_gap_(from_seconds(config.max_gap)),
      front_end_(config.enabled ? gpr::make_front_end(config) : nullptr) {}

RadarAnswer RadarTask::run(const std::vector<GprTrace>& traces, TimeNs tick) {
  RadarAnswer answer;
  for (const GprTrace& trace : traces) {
    std::string note;
    if (last_time_ > 0) {
      if (trace.samples.size() != num_samples_)
        note = "trace length changed";
      else if (std::abs(trace.sample_interval_s - sample_interval_s_) > 1e-6 * sample_interval_s_)
        note = "sample interval changed";
      else if (trace.time - last_time_ > max_gap_)
        note = "gap in traces";
    }
    if (!note.empty()) {
      front_end_->reset();
      answer.notes.push_back(note + ": the radar front end starts afresh");
    }
    last_time_ = trace.time;
    num_samples_ = trace.samples.size();
    sample_interval_s_ = trace.sample_interval_s;
    front_end_->add_trace(trace);
  }
  answer.findings = front_end_->tick(tick);
  answer.sfm = front_end_->sfm();
  return answer;
}

}  // namespace gprodom
