#include "motion/rest/vibration.h"

#include <algorithm>
#include <vector>

namespace gprodom {

namespace {

constexpr std::size_t kMost = 600;     // intervals between states: two minutes of driving
constexpr std::size_t kFewest = 5;     // a second
constexpr double kQuietDriving = 0.1;  // share of the driving that vibrates less than its low level

// A sensor tells standing from driving if the low level of driving is this many times the level at
// rest.
constexpr double kApart = 1.6;
// Before the robot has driven, an engine may vibrate this many times as much as it
// did at first.
constexpr double kIdles = 2.0;

}  // namespace

void Vibration::drives(const ImuNoise& measured) {
  driving_.push_back(measured);
  if (driving_.size() > kMost) driving_.pop_front();
}

// The level that a share of the driving is below.
double Vibration::driving(double ImuNoise::*sensor, double share) const {
  std::vector<double> levels;
  levels.reserve(driving_.size());
  for (const ImuNoise& noise : driving_) levels.push_back(noise.*sensor);
  const auto index = static_cast<long>(share * static_cast<double>(levels.size()));
  std::nth_element(levels.begin(), levels.begin() + index, levels.end());
  return levels[static_cast<std::size_t>(index)];
}

bool Vibration::far_below_driving(const ImuNoise& measured) const {
  constexpr double kFarBelow = 0.5;  // times the median
  return !driving_.empty() &&
         measured.accel_density < kFarBelow * driving(&ImuNoise::accel_density, 0.5);
}

bool Vibration::hides_rest(const ImuNoise& measured, const std::optional<ImuNoise>& at_rest) const {
  if (!at_rest) return true;
  for (const auto sensor : {&ImuNoise::gyro_density, &ImuNoise::accel_density}) {
    const double rest = (*at_rest).*sensor;
    const bool tells = driving_.size() < kFewest ? measured.*sensor > kIdles * rest
                                                 : driving(sensor, kQuietDriving) > kApart * rest;
    if (tells) return false;
  }
  return true;
}

}  // namespace gprodom
