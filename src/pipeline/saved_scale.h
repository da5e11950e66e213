// The wheel's scale from one run to the next, so that a robot calibrates itself over days.
#pragma once

#include <string>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/types.h"

namespace gprodom {

class SavedScale {
 public:
  explicit SavedScale(const StateConfig& config);

  // The configuration with what the last run left as the prior of the scale; as it is where nothing
  // was left, the scale is held, or the configuration knows better. Adds to notices what was done.
  Config taken_up(Config config, std::vector<std::string>& notices) const;

  // Saves the scale every save_period of data time. Returns what went wrong, once.
  std::string save(const OdometryEstimate& newest);

 private:
  std::string path_;  // empty: nothing is kept
  TimeNs period_, last_ = 0;
  bool failed_ = false;
};

}  // namespace gprodom
