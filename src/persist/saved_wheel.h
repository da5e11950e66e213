// The wheel's scale and lateral position, and the turn calibration of left and right wheels, as
// learnt by a run.
#pragma once

#include <string>
#include <string_view>

#include "gprodom/config.h"
#include "motion/turn_calibration.h"
#include "motion/wheel_position.h"

namespace gprodom {

// The configured wheel as text. If the text has changed, the wheel is another one, and nothing that
// was learnt applies to it.
std::string wheel_setting(const Config& config);

struct SavedWheel {
  double scale = 1.0;   // reported over true distance
  double sigma = 0.02;  // standard deviation
  std::string setting;  // wheel_setting() when it was learnt
};

std::string to_bytes(const SavedWheel& wheel);

// name: of the file, for errors. Throws FileError where it is not a whole one that makes sense.
SavedWheel saved_wheel_from(const std::string& name, std::string_view bytes);

// Likewise its lateral position.
struct SavedPosition {
  LearntPosition learnt;
  std::string setting;  // wheel_setting() when it was learnt
};

std::string to_bytes(const SavedPosition& position);
SavedPosition saved_position_from(const std::string& name, std::string_view bytes);

// The same for the configured pair of wheels.
std::string pair_setting(const Config& config);

struct SavedPair {
  LearntTurn learnt;
  std::string setting;  // pair_setting() when it was learnt
};

std::string to_bytes(const SavedPair& pair);
SavedPair saved_pair_from(const std::string& name, std::string_view bytes);  // likewise

}  // namespace gprodom
