#include "motion/vibration.h"

#include <algorithm>
#include <vector>

namespace gprodom {

namespace {

constexpr std::size_t kMost = 600;     // intervals: two minutes of driving
constexpr std::size_t kFewest = 50;    // ten seconds
constexpr double kQuietDriving = 0.1;  // share of the driving that vibrates less than its low level

// A sensor tells standing from driving if the low level of driving is this many times the level at
// rest.
constexpr double kApart = 1.6;
// Before the robot has driven for long enough, an engine may vibrate this many times as much as it
// did at first.
constexpr double kIdles = 2.0;

}  // namespace

void Vibration::drives(const ImuNoise& measured) {
  driving_.push_back(measured);
  if (driving_.size() > kMost) driving_.pop_front();
}

double Vibration::low_of_driving(double ImuNoise::*sensor) const {
  std::vector<double> levels;
  levels.reserve(driving_.size());
  for (const ImuNoise& noise : driving_) levels.push_back(noise.*sensor);
  const auto share = kQuietDriving * static_cast<double>(levels.size());
  const auto low = levels.begin() + static_cast<long>(share);
  std::nth_element(levels.begin(), low, levels.end());
  return *low;
}

bool Vibration::hides_rest(const ImuNoise& measured, const std::optional<ImuNoise>& at_rest) const {
  if (!at_rest) return true;
  for (const auto sensor : {&ImuNoise::gyro_density, &ImuNoise::accel_density}) {
    const double rest = (*at_rest).*sensor;
    const bool tells = driving_.size() < kFewest ? measured.*sensor > kIdles * rest
                                                 : low_of_driving(sensor) > kApart * rest;
    if (tells) return false;
  }
  return true;
}

}  // namespace gprodom
