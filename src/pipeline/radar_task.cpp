#include "pipeline/radar_task.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "gpr/front_end_factory.h"

namespace gprodom {

namespace {

std::unique_ptr<gpr::FrontEnd> made(const gpr::FrontEndFactory& factory) {
  auto front_end = factory();
  if (!front_end) throw std::invalid_argument("the factory has returned no radar front end");
  return front_end;
}

// Traces further apart lie on other ground: nothing can be compared across the gap.
constexpr TimeNs kMaxGap = 1'000'000'000;  // ns

bool usable(const gpr::Standstill& s) { return std::isfinite(s.score) && s.sigma_m > 0; }
bool usable(const gpr::PathLength& p) {
  return std::isfinite(p.score) && (!p.valid || (p.lengths > 0 && std::isfinite(p.lengths)));
}
bool usable(const gpr::TrackDisplacement& d) {
  return std::isfinite(d.score) && (!d.valid || (std::isfinite(d.distance_m) && d.sigma_m > 0));
}
bool usable(const gpr::Sight& s) { return s.times_least > 0 && std::isfinite(s.times_least); }

// Removes findings with impossible values, and notes them.
void drop_unusable(TimeNs tick, RadarAnswer& answer) {
  const auto unusable = [&](const gpr::Finding& finding) {
    return std::visit([&](const auto& f) { return !(usable(f) && f.from < f.to && f.to <= tick); },
                      finding);
  };
  auto& findings = answer.findings;
  const auto first = std::remove_if(findings.begin(), findings.end(), unusable);
  if (first == findings.end()) return;
  findings.erase(first, findings.end());
  answer.notes.emplace_back("finding of the radar front end dropped: impossible value");
}

}  // namespace

RadarTask::RadarTask(const GprConfig& config, const gpr::FrontEndFactory& front_end)
    : is_ours_(!front_end) {
  if (config.enabled) front_end_ = front_end ? made(front_end) : gpr::make_front_end(config);
  if (const auto row = gpr::antenna_row(config)) pair_.emplace(config, *row);
}

void RadarTask::add(const GprTrace& trace, bool has_pauses, RadarAnswer& answer) {
  const TraceFormat format = format_of(trace);
  std::string note;
  if (last_time_ > 0) {
    if (format.samples != format_.samples)
      note = "trace length changed";
    else if (!same_interval(format_, format))
      note = "sample interval changed";
    else if (trace.antenna_id != antenna_)
      note = "another antenna";
    else if (!has_pauses && trace.time - last_time_ > kMaxGap)
      note = "gap in traces";
  }
  if (!note.empty()) {
    front_end_->reset();
    answer.notes.push_back(note + ": the radar front end is reset");
  }
  last_time_ = trace.time;
  antenna_ = trace.antenna_id;
  format_ = format;
  front_end_->add_trace(trace);
}

RadarAnswer RadarTask::run(const std::vector<GprTrace>& traces, TimeNs tick, int antenna,
                           const gpr::Travel& travel, Trigger trigger) {
  RadarAnswer answer;
  answer.antenna = antenna;
  const bool by_distance = trigger == Trigger::kDistance;
  const bool asks = front_end_ && !(by_distance && is_ours_);
  for (const GprTrace& trace : traces) {
    if (asks && trace.antenna_id == antenna) add(trace, by_distance, answer);
    if (pair_) pair_->add_trace(trace, by_distance);
  }
  if (asks) {
    answer.findings = front_end_->tick(tick);
    drop_unusable(tick, answer);
    answer.sfm = front_end_->sfm();
    if (trigger == Trigger::kAuto && is_ours_) answer.findings.clear();
  }
  if (pair_) {
    answer.passages = pair_->tick(tick, travel);
    answer.pair = pair_->state();
  }
  return answer;
}

}  // namespace gprodom
