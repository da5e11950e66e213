// What a run has learnt of the wheel's scale, and of how left and right wheels turn the robot.
#pragma once

#include <string>
#include <string_view>

#include "gprodom/config.h"
#include "motion/turn_calibration.h"

namespace gprodom {

// Which wheel the configuration speaks of, as text: another text, and nothing that was learnt
// holds.
std::string wheel_setting(const Config& config);

struct SavedWheel {
  double scale = 1.0;   // reported over true distance
  double sigma = 0.02;  // standard deviation
  std::string setting;  // wheel_setting() when it was learnt
};

std::string to_bytes(const SavedWheel& wheel);

// name: of the file, for errors. Throws FileError where it is not a whole one that makes sense.
SavedWheel saved_wheel_from(const std::string& name, std::string_view bytes);

// Of which pair of wheels the configuration speaks, likewise.
std::string pair_setting(const Config& config);

struct SavedPair {
  LearntTurn learnt;
  std::string setting;  // pair_setting() when it was learnt
};

std::string to_bytes(const SavedPair& pair);
SavedPair saved_pair_from(const std::string& name, std::string_view bytes);  // likewise

}  // namespace gprodom
