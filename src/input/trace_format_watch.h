// Traces of one radar setting: number of samples and sample interval.
#pragma once

#include <string>

#include "base/trace_format.h"
#include "gprodom/types.h"

namespace gprodom {

// A change of the setting makes the radar parts start afresh and forget the ground. A damaged
// message must not do that, so a new setting counts once several traces in a row have it.
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
