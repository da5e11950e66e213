// Makes traces of one antenna those that another one would have measured over the same ground, so
// that revisits are found from one to the other. Gain, time zero and pulse of an antenna are a
// linear filter of its traces. Over many metres, antennas of one robot have the same mean trace but
// for that filter: the direct wave and flat layers. So the filter from one to the other is the one
// that makes the mean trace of the one that of the other.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>

#include "base/trace_format.h"
#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom::gpr {

class AntennaFilter {
 public:
  // band: of the antennas.
  explicit AntennaFilter(const GprFilterConfig& band);

  // A trace of any antenna.
  void learn(const GprTrace& trace);

  // The trace as antenna `to` would have measured it; unchanged where too little is known of one of
  // the two, or their settings differ.
  GprTrace as_of(int to, GprTrace trace) const;

 private:
  struct Mean {
    TraceFormat format;
    Eigen::VectorXd trace;  // of the newest traces
    std::size_t traces = 0;
  };
  const Mean* mean_of(int antenna) const;  // nullptr: too little is known

  double period_s_;  // of the band's centre
  std::map<int, Mean> means_;
};

}  // namespace gprodom::gpr
