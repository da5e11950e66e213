// The reason why a measurement cannot be used, as a text for the log; empty if it can.
#pragma once

#include <string>

#include "gprodom/config.h"
#include "gprodom/position_fix.h"
#include "gprodom/types.h"

namespace gprodom {

std::string fault(const ImuSample& sample, const Config& config);
std::string fault(const WheelSample& sample, const Config& config);
std::string fault(const WheelsSample& sample, const Config& config);
std::string fault(const GprTrace& trace, const Config& config);
std::string fault(const PositionFix& fix, const Config& config);
std::string fault(const Displacement& displacement, const Config& config);

}  // namespace gprodom
