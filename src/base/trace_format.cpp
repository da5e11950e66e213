#include "base/trace_format.h"

#include <array>
#include <cstdio>

namespace gprodom {

std::string text_of(const TraceFormat& format) {
  std::array<char, 60> text{};
  std::snprintf(text.data(), text.size(), "%zu samples at %.6g ns", format.samples,
                1e9 * format.sample_interval_s);
  return text.data();
}

}  // namespace gprodom
