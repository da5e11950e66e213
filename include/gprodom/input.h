// All inputs as one type, which live and replay feed to the estimator.
#pragma once

#include <string>
#include <variant>

#include "gprodom/choices.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"

namespace gprodom {

// A command as received: `name` should be one of CommandName. Argument of reset: empty, or
// kResetAll, which forgets the ground too; of save_map and load_map: the map's name; of locate_at:
// "X Y YAW SIGMA", and the number of the map where there are several (RoughPlace).
struct Command {
  TimeNs time = 0;
  std::string name;
  std::string argument;
};

constexpr char kResetAll[] = "all";

// A message that could not be used, with the reason.
struct Rejection {
  std::string channel;
  std::string reason;
};

using Input = std::variant<ImuSample, WheelSample, WheelsSample, GprTrace, Displacement,
                           PositionFix, Command, Rejection>;

}  // namespace gprodom
