#include "input/clock_watch.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

bool ClockWatch::drifts(TimeNs stamp, TimeNs imu_now) {
  if (imu_now < begin_ || imu_now > begin_ + 2 * kWindow) {  // at the start, and after a silence
    *this = {};
    first_ = begin_ = imu_now;
  }
  bool told = false;
  if (imu_now >= begin_ + kWindow) {
    if (offsets_s_.size() >= kFewestMessages) {
      const auto middle = offsets_s_.begin() + static_cast<long>(offsets_s_.size() / 2);
      std::nth_element(offsets_s_.begin(), middle, offsets_s_.end());
      windows_.push_back({to_seconds(begin_ - first_), *middle});
      if (windows_.size() > kMostWindows) windows_.pop_front();
      told = judge();
    }
    offsets_s_.clear();
    begin_ += kWindow;
  }
  offsets_s_.push_back(to_seconds(stamp - imu_now));
  return told;
}

// The regression line through windows `from` to `to` - 1; its standard deviation by the residuals.
ClockWatch::Line ClockWatch::fit(std::size_t from, std::size_t to) const {
  const auto n = static_cast<double>(to - from);
  double time = 0, offset = 0, tt = 0, cross = 0, oo = 0;
  for (std::size_t i = from; i < to; ++i) {
    time += windows_[i].time_s / n;
    offset += windows_[i].offset_s / n;
  }
  for (std::size_t i = from; i < to; ++i) {
    const double t = windows_[i].time_s - time, o = windows_[i].offset_s - offset;
    tt += t * t;
    cross += t * o;
    oo += o * o;
  }
  const double pace = cross / tt;
  const double scatter = std::max(0.0, oo - pace * cross) / (n - 2);
  return {pace, std::sqrt(std::max(scatter, kLeastScatter_s * kLeastScatter_s) / tt)};
}

// Both halves must drift in the same direction, since a single step of the delay lies in one half.
bool ClockWatch::judge() const {
  const std::size_t n = windows_.size();
  if (n < kFewestWindows) return false;
  const Line all = fit(0, n);
  const double least = std::max(kWorstPace, kSignificance * all.sigma);
  if (std::abs(all.pace) < least) return false;
  const double sign = all.pace > 0 ? 1.0 : -1.0;
  return sign * fit(0, n / 2).pace > 0.5 * kWorstPace &&
         sign * fit(n / 2, n).pace > 0.5 * kWorstPace;
}

}  // namespace gprodom
