// Follows the setting of the radar: number of samples and sample interval.
#pragma once

#include <optional>
#include <string>

#include "base/trace_format.h"
#include "gprodom/types.h"

namespace gprodom {

// When the setting changes, the front end restarts and other ground is stored. A damaged message
// must not cause that, so a new setting is accepted only after several traces in a row. The first
// trace is used at once, but its setting counts for the ground only when others agree.
class TraceFormatWatch {
 public:
  // Empty where the trace is usable, else the reason to drop it.
  std::string check(const GprTrace& trace);

  // The setting that several traces agree in; nothing before.
  std::optional<TraceFormat> agreed() const;

 private:
  // Traces that make a setting. One that differs by chance does so from each of the others too.
  static constexpr int kToAgree = 5;

  TraceFormat current_, candidate_;
  int agreed_ = 0;    // traces of the current setting, up to kToAgree
  int agreeing_ = 0;  // traces in a row of the candidate
};

}  // namespace gprodom
