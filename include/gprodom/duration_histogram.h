// Histogram of durations: quantiles with an error of up to 9 %, in a fixed amount of memory.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace gprodom {

class DurationHistogram {
 public:
  void add(double seconds) {
    longest_s_ = std::max(longest_s_, seconds);
    const double steps = kPerOctave * std::log2(std::max(seconds, kShortest) / kShortest);
    ++counts_[static_cast<std::size_t>(std::min(steps, kBuckets - 1.0))];
    ++count_;
  }

  std::int64_t count() const { return count_; }
  double longest() const { return longest_s_; }  // s

  // The quantile (s) of a share (0 to 1) of all durations, rounded up; 0 if there is none. Resolves
  // durations from 1 us to 16 s.
  double quantile(double share) const {
    const double wanted = std::clamp(share, 0.0, 1.0) * static_cast<double>(count_);
    double passed = 0.0;
    for (int i = 0; i < kBuckets; ++i) {
      passed += static_cast<double>(counts_[static_cast<std::size_t>(i)]);
      if (count_ > 0 && passed >= wanted)
        return std::min(kShortest * std::exp2(static_cast<double>(i + 1) / kPerOctave), longest_s_);
    }
    return longest_s_;
  }

 private:
  static constexpr int kPerOctave = 8, kBuckets = 24 * kPerOctave;
  static constexpr double kShortest = 1e-6;  // s

  std::array<std::int64_t, kBuckets> counts_{};
  std::int64_t count_ = 0;
  double longest_s_ = 0.0;
};

}  // namespace gprodom
