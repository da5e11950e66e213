#include "gpr/filter/clipping.h"

#include <algorithm>

namespace gprodom::gpr {

void ClippingDetector::learn(Rail& rail, float value, bool beyond) {
  if (beyond) {
    rail = {value, 1};
  } else if (value == rail.value && rail.hits < kRepeats) {
    ++rail.hits;
  }
}

void ClippingDetector::mark(const std::vector<float>& samples, int margin, float* used) {
  if (samples.empty()) return;
  const auto [lowest, highest] = std::minmax_element(samples.begin(), samples.end());
  learn(top_, *highest, *highest > top_.value);
  learn(bottom_, *lowest, *lowest < bottom_.value);
  const bool top = top_.hits >= kRepeats && *highest >= top_.value;
  const bool bottom = bottom_.hits >= kRepeats && *lowest <= bottom_.value;
  if ((!top && !bottom) || top_.value <= bottom_.value) return;
  const int n = static_cast<int>(samples.size());
  for (int i = 0; i < n; ++i) {
    if ((top && samples[i] >= top_.value) || (bottom && samples[i] <= bottom_.value)) {
      for (int j = std::max(0, i - margin); j <= std::min(n - 1, i + margin); ++j) used[j] = 0.0f;
    }
  }
}

}  // namespace gprodom::gpr
