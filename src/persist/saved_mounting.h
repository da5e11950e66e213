// imu.rpy_body_imu as a run has found it (auto).
#pragma once

#include <string>
#include <string_view>

#include "input/mounting_watch.h"

namespace gprodom {

struct SavedMounting {
  FoundMounting found;
  std::string channel;  // channels.imu, when it was found
};

std::string to_bytes(const SavedMounting& mounting);

// name: of the file, for errors. Throws FileError where it is not a whole one that makes sense.
SavedMounting saved_mounting_from(const std::string& name, std::string_view bytes);

}  // namespace gprodom
