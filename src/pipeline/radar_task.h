// The work of the radar thread at one tick: passes traces to the front end and returns its answer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/trace_format.h"
#include "gpr/pair/pair_front_end.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"
#include "gprodom/types.h"

namespace gprodom {

struct RadarAnswer {
  std::vector<gpr::Finding> findings;
  std::optional<SubsurfaceFeatureMatrix> sfm;  // if the front end makes one and it is asked for
  std::vector<gpr::Passage> passages;          // of antennas in a row
  std::optional<gpr::PairState> pair;          // if there are such antennas
  int antenna = 0;                             // that the findings are of
  std::vector<std::string> notes;              // e.g. why the front end was reset
};

class RadarTask {
 public:
  // front_end: replaces config.front_end unless it is empty.
  explicit RadarTask(const GprConfig& config, const gpr::FrontEndFactory& front_end = {});

  bool enabled() const { return front_end_ || pair_; }
  bool has_pair() const { return pair_.has_value(); }

  // traces: those since the last tick, in time order for each antenna. The front end gets those of
  // `antenna`; it is reset if a trace has another length or sample interval than the last, or
  // follows a gap, or is of another antenna. travel: for antennas in a row.
  // trigger: of the traces. By distance they come as evenly along the way as the wheel that makes
  // them, at whatever speed: their likeness tells the wheel's way again, and none shows a
  // standstill. So the front ends of ours are asked nothing then, and while it is not known
  // (kAuto) their answers do not count. One of another maker goes on, and is not reset by a stop.
  RadarAnswer run(const std::vector<GprTrace>& traces, TimeNs tick, int antenna = 0,
                  const gpr::Travel& travel = {}, Trigger trigger = Trigger::kTime);

 private:
  void add(const GprTrace& trace, bool has_pauses, RadarAnswer& answer);

  const bool is_ours_;  // the front end
  std::unique_ptr<gpr::FrontEnd> front_end_;
  std::optional<gpr::PairFrontEnd> pair_;
  TimeNs last_time_ = 0;
  int antenna_ = 0;  // of the last trace
  TraceFormat format_;
};

}  // namespace gprodom
