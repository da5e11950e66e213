// Everything that comes in from outside, as one type: what live and replay feed to the estimator.
#pragma once

#include <string>
#include <variant>

#include "gprodom/types.h"

namespace gprodom {

// An operator's wish: "reset".
struct Command {
  TimeNs time = 0;
  std::string name;
  std::string argument;
};

// A message that could not be used, and why.
struct Rejection {
  std::string channel;
  std::string reason;
};

using Input = std::variant<ImuSample, WheelSample, GprTrace, Displacement, Command, Rejection>;

}  // namespace gprodom
