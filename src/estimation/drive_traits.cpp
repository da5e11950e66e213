#include "estimation/drive_traits.h"

#include <cmath>

namespace gprodom {

namespace {

// A tyre's slip angle is its lateral over its vertical force, over this: 1/rad. Tyres of cars and
// field robots have 10 to 25.
constexpr double kCorneringStiffness = 15.0;
constexpr double kGravity = 9.8;  // m/s^2

}  // namespace

DriveTraits drive_traits(const WheelConfig& config) {
  const double track = config.track;
  if (config.drive == WheelDrive::kDifferential)
    return {true, track, 0.05 * track, 5e-4 * track, 0.01, 0.01 * track};
  // Effective over geometric track: 1.6 to 2.0 on grass, gravel, asphalt and ice (Warthog).
  if (config.drive == WheelDrive::kSkidSteer)
    return {true, 1.75 * track, 0.35 * track, 5e-3 * track, 0.1, 0.1 * track};
  if (config.drive == WheelDrive::kAckermann)
    return {true, track, 0.05 * track, 5e-4 * track, 0.01, 0.01 * track};
  return {};
}

double side_slip(const DriveTraits& traits, double turned, double speed) {
  if (!traits.turns_by_difference) return 0.0;
  const double creep = speed * speed / (kCorneringStiffness * kGravity);
  return (traits.side_slip_m_per_rad + creep) * std::abs(turned);
}

}  // namespace gprodom
