// What the kind of drive (wheel.drive) lets a robot do that a single wheel does not know of.
#pragma once

#include "gprodom/config.h"

namespace gprodom {

// Before anything is learnt on the way. docs/estimation.md, "Two wheels".
struct DriveTraits {
  bool turns_by_difference = false;  // the difference of left and right is a turn of the body
  double track_m = 0.0;              // effective track
  double track_sigma_m = 0.0;
  double track_walk_m = 0.0;         // m/sqrt(m), over the path of both sides: the ground changes
  double difference_noise_m = 0.0;   // m/sqrt(m), likewise: of right less left
  double side_slip_m_per_rad = 0.0;  // sideways, while the body turns: the centre of it wanders
};

DriveTraits drive_traits(const WheelConfig& config);

// Standard deviation (m) of a displacement to the side while the body turns by `turned` (rad) at
// `speed` (m/s): the centre of rotation wanders, and tyres creep to the side under the force that
// bends the way.
double side_slip(const DriveTraits& traits, double turned, double speed);

}  // namespace gprodom
