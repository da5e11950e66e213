#include "input/trace_format_watch.h"

#include <algorithm>

namespace gprodom {

std::string TraceFormatWatch::check(const GprTrace& trace) {
  const TraceFormat format = format_of(trace);
  if (current_.samples == 0) current_ = format;
  if (same_format(current_, format)) {
    agreeing_ = 0;
    agreed_ = std::min(agreed_ + 1, kToAgree);
    return {};
  }
  agreeing_ = agreeing_ > 0 && same_format(candidate_, format) ? agreeing_ + 1 : 1;
  candidate_ = format;
  if (agreeing_ < kToAgree) return "length or sample interval unlike the traces before";
  current_ = format;
  agreed_ = kToAgree;
  agreeing_ = 0;
  return {};
}

std::optional<TraceFormat> TraceFormatWatch::agreed() const {
  return agreed_ < kToAgree ? std::nullopt : std::optional(current_);
}

}  // namespace gprodom
