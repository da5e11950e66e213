// Traces of one radar setting: number of samples and sample interval.
#pragma once

#include <string>

#include "gprodom/types.h"

namespace gprodom {

// A change of the setting makes the radar parts start afresh and forget the ground. A damaged
// message must not do that, so a new setting counts once several traces in a row have it.
class TraceFormat {
 public:
  // Empty where the trace is usable, else the reason to drop it.
  std::string check(const GprTrace& trace);

 private:
  struct Format {
    std::size_t samples = 0;
    double interval_s = 0.0;

    bool operator==(const Format& other) const;
  };
  static constexpr int kToChange = 5;  // traces in a row

  Format current_, candidate_;
  int agreeing_ = 0;  // traces in a row of the candidate
};

}  // namespace gprodom
