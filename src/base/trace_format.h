// The setting of a radar, read from its traces.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "base/text.h"
#include "gprodom/types.h"

namespace gprodom {

struct TraceFormat {
  std::size_t samples = 0;  // of a trace; 0: no trace was seen
  double sample_interval_s = 0.0;
};

inline TraceFormat format_of(const GprTrace& trace) {
  return {trace.samples.size(), trace.sample_interval_s};
}

// Tolerates differences in the last digits, as of intervals that were written as decimal numbers.
inline bool same_interval(const TraceFormat& a, const TraceFormat& b) {
  return std::abs(b.sample_interval_s - a.sample_interval_s) <= 1e-6 * a.sample_interval_s;
}

// Traces of the two can be compared with each other.
inline bool same_format(const TraceFormat& a, const TraceFormat& b) {
  return a.samples == b.samples && same_interval(a, b);
}

// Such as "201 samples at 0.2 ns".
inline std::string text_of(const TraceFormat& format) {
  return formatted("%zu samples at %.6g ns", format.samples, 1e9 * format.sample_interval_s);
}

}  // namespace gprodom
