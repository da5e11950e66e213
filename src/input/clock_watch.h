// Whether a sensor's clock runs at the pace of the IMU's. An offset that stays cannot be told from
// a delay; one that grows steadily can.
#pragma once

#include <deque>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

// A line through the medians of how far the sensor's stamps are ahead of the IMU's as they come.
// Delays scatter and medians bear that; they do not grow for minutes.
class ClockWatch {
 public:
  // A message's stamp, and the newest of the IMU when it came. True now and then for as long as
  // the clocks drift apart by more than kWorstPace, and significantly.
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
