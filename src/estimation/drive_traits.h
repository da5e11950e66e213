// Properties of the kinds of drive (wheel.drive): how the robot turns and slips sideways.
#pragma once

#include <cmath>

#include "gprodom/config.h"

namespace gprodom {

// The prior, before anything is learnt while driving. docs/estimation.md, "Two wheels".
struct DriveTraits {
  bool turns_by_difference = false;  // the difference of left and right turns the body
  double track_m = 0.0;              // effective track
  double track_sigma_m = 0.0;
  double track_walk_m = 0.0;          // m/sqrt(m), over the path of both sides (changes of ground)
  double difference_noise_m = 0.0;    // m/sqrt(m), likewise: noise of right less left
  double side_slip_m_per_rad = 0.0;   // in a turn, since the centre of rotation wanders
  double track_between_runs_m = 0.0;  // change of the effective track from run to run
};

inline DriveTraits drive_traits(const WheelConfig& config) {
  const double track = config.track;
  if (config.drive == WheelDrive::kDifferential || config.drive == WheelDrive::kAckermann)
    return {true, track, 0.05 * track, 5e-4 * track, 0.01, 0.01 * track, 5e-3 * track};
  // Effective over geometric track: 1.6 to 2.0 on grass, gravel, asphalt and ice (Warthog). The
  // next run may be on other ground.
  if (config.drive == WheelDrive::kSkidSteer)
    return {true, 1.75 * track, 0.35 * track, 5e-3 * track, 0.1, 0.1 * track, 0.15 * track};
  return {};
}

// Cornering stiffness of a tyre: lateral over vertical force per slip angle, 1/rad. Tyres of cars
// and field robots have 10 to 25.
inline constexpr double kCorneringStiffness = 15.0;

// Standard deviation (m) of a displacement to the side while the body turns by `turned` (rad) at
// `speed` (m/s): tyres creep sideways under the centripetal force, and with left and right wheels
// the centre of rotation wanders as well.
inline double side_slip(const DriveTraits& traits, double turned, double speed) {
  constexpr double kGravity = 9.8;  // m/s^2
  const double creep = speed * speed / (kCorneringStiffness * kGravity);
  return (traits.side_slip_m_per_rad + creep) * std::abs(turned);
}

}  // namespace gprodom
