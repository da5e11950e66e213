// Follows the setting of the radar: number of samples and sample interval.
#pragma once

#include <string>

#include "base/trace_format.h"
#include "gprodom/types.h"

namespace gprodom {

// When the setting changes, the front end restarts and the ground is forgotten. A damaged message
// must not cause that, so a new setting is accepted only after several traces in a row.
class TraceFormatWatch {
 public:
  // Empty where the trace is usable, else the reason to drop it.
  std::string check(const GprTrace& trace);

 private:
  static constexpr int kToChange = 5;  // traces in a row

  TraceFormat current_, candidate_;
  int agreeing_ = 0;  // traces in a row of the candidate
};

}  // namespace gprodom
