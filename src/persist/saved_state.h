// The state of the estimator at one moment, from which it can continue a few seconds later.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "estimation/state_input.h"
#include "gprodom/types.h"

namespace gprodom {

struct SavedState {
  NavState state;
  StateMatrix covariance = StateMatrix::Identity();  // positive definite
  ImuNoise noise;                                    // at standstill
  double accel_scale = 1.0;                          // by which forces are divided
  std::optional<double> wheel_m;                     // the wheel's own count at the state's time
  double distance_m = 0.0;                           // driven since the start, as published
  // The map -> odom correction in force, with the covariance of the pose in map now; nothing while
  // map is odom.
  std::optional<Correction> correction;
  int map = 0;                // which map of the ground's; -1: none, the ground is another one
  std::uint64_t ground = 0;   // file that the ground was taken up from (GroundMap::taken_from())
  std::string wheel_setting;  // of learnt.h, then
};

std::string to_bytes(const SavedState& saved);

// name: of the file, for errors. Throws FileError where it is not a whole state that makes sense.
SavedState saved_state_from(const std::string& name, std::string_view bytes);

}  // namespace gprodom
