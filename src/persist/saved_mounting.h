// The mounting of the IMU that a run has found (imu.rpy_body_imu: auto).
#pragma once

#include <string>
#include <string_view>

#include "base/learnt_mounting.h"

namespace gprodom {

std::string to_bytes(const LearntMounting& mounting);

// name: of the file, for errors. Throws FileError where it is not a whole one that makes sense.
LearntMounting saved_mounting_from(const std::string& name, std::string_view bytes);

}  // namespace gprodom
