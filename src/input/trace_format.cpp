#include "input/trace_format.h"

#include <cmath>

namespace gprodom {

bool TraceFormat::Format::operator==(const Format& other) const {
  return samples == other.samples && std::abs(interval_s - other.interval_s) <= 1e-6 * interval_s;
}

std::string TraceFormat::check(const GprTrace& trace) {
  const Format format{trace.samples.size(), trace.sample_interval_s};
  if (current_.samples == 0) current_ = format;
  if (current_ == format) {
    agreeing_ = 0;
    return {};
  }
  agreeing_ = agreeing_ > 0 && candidate_ == format ? agreeing_ + 1 : 1;
  candidate_ = format;
  if (agreeing_ < kToChange) return "length or sample interval unlike the traces before";
  current_ = format;
  agreeing_ = 0;
  return {};
}

}  // namespace gprodom
