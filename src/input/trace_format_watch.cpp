#include "input/trace_format_watch.h"

namespace gprodom {

std::string TraceFormatWatch::check(const GprTrace& trace) {
  const TraceFormat format = format_of(trace);
  if (current_.samples == 0) current_ = format;
  if (same_format(current_, format)) {
    agreeing_ = 0;
    return {};
  }
  agreeing_ = agreeing_ > 0 && same_format(candidate_, format) ? agreeing_ + 1 : 1;
  candidate_ = format;
  if (agreeing_ < kToChange) return "length or sample interval unlike the traces before";
  current_ = format;
  agreeing_ = 0;
  return {};
}

}  // namespace gprodom
