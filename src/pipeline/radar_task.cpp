#include "pipeline/radar_task.h"

#include "gpr/front_end_factory.h"

namespace gprodom {

RadarTask::RadarTask(const GprConfig& config)
    : max_gap_(from_seconds(config.max_gap)),
      front_end_(config.enabled ? gpr::make_front_end(config) : nullptr) {}

RadarAnswer RadarTask::run(const std::vector<GprTrace>& traces, TimeNs tick) {
  RadarAnswer answer;
  for (const GprTrace& trace : traces) {
    const TraceFormat format = format_of(trace);
    std::string note;
    if (last_time_ > 0) {
      if (format.samples != format_.samples)
        note = "trace length changed";
      else if (!same_interval(format_, format))
        note = "sample interval changed";
      else if (trace.time - last_time_ > max_gap_)
        note = "gap in traces";
    }
    if (!note.empty()) {
      front_end_->reset();
      answer.notes.push_back(note + ": the radar front end starts afresh");
    }
    last_time_ = trace.time;
    format_ = format;
    front_end_->add_trace(trace);
  }
  answer.findings = front_end_->tick(tick);
  answer.sfm = front_end_->sfm();
  return answer;
}

}  // namespace gprodom
