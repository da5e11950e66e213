// Detects a sensor's clock that drifts against the IMU's. A constant offset cannot be distinguished
// from a delay; one that grows steadily can.
#pragma once

#include <deque>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

// Fits a line to the offset of the sensor's stamps against the IMU's when they arrive, by medians
// over windows. Medians suppress the scatter of delays, and delays do not grow for minutes.
class ClockWatch {
 public:
  // stamp: of a message; imu_now: the newest stamp of the IMU when it arrived. True once per window
  // while the clocks drift apart significantly and by more than kWorstPace.
  bool drifts(TimeNs stamp, TimeNs imu_now);

 private:
  struct Window {
    double time_s, offset_s;
  };
  struct Line {
    double pace, sigma;  // its slope
  };

  Line fit(std::size_t from, std::size_t to) const;
  bool judge() const;

  static constexpr double kWorstPace = 50e-6;      // 50 ppm: 0.18 s in an hour
  static constexpr double kSignificance = 6.0;     // standard deviations
  static constexpr double kLeastScatter_s = 1e-4;  // of a median
  static constexpr TimeNs kWindow = 10'000'000'000;
  static constexpr std::size_t kFewestWindows = 6, kMostWindows = 18, kFewestMessages = 20;

  TimeNs first_ = 0;               // of all
  TimeNs begin_ = 0;               // of the window that is being filled
  std::vector<double> offsets_s_;  // in it
  std::deque<Window> windows_;     // newest last
};

}  // namespace gprodom
