// The default front end: standstill and coherence, the two measurements of motion that a single
// antenna gives without revisits.
#pragma once

#include "gpr/motion/coherence.h"
#include "gpr/motion/stationarity.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

class MotionFrontEnd : public FrontEnd {
 public:
  explicit MotionFrontEnd(const GprConfig& config) : coherence_(config) {}

  void add_trace(const GprTrace& trace) override {
    stationarity_.add_trace(trace);
    coherence_.add_trace(trace);
  }
  std::vector<Finding> tick(TimeNs tick) override {
    std::vector<Finding> all = stationarity_.tick(tick);
    for (Finding& finding : coherence_.tick(tick)) all.push_back(std::move(finding));
    return all;
  }
  void reset() override {
    stationarity_.reset();
    coherence_.reset();
  }

 private:
  StationarityFrontEnd stationarity_;
  CoherenceFrontEnd coherence_;
};

}  // namespace gprodom::gpr
