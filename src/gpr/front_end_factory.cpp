#include "gpr/front_end_factory.h"

#include "gpr/motion/motion_front_end.h"
#include "gpr/motion/stationarity.h"
#include "gpr/sequential/sequential.h"
#include "gprodom/error.h"

namespace gprodom::gpr {

std::unique_ptr<FrontEnd> make_front_end(const GprConfig& config) {
  if (config.front_end == "none") return nullptr;
  if (config.front_end == "stationarity") {
    return std::make_unique<StationarityFrontEnd>(config.stationary_window);
  }
  if (config.front_end == "motion") return std::make_unique<MotionFrontEnd>(config);
  for (const char* name : {"sfm", "bscan", "dec", "trace_count"}) {
    if (config.front_end == name) return std::make_unique<SequentialFrontEnd>(config);
  }
  throw ConfigError("gpr.front_end: unknown name \"" + config.front_end +
                    "\"; expected motion, stationarity, sfm, bscan, dec, trace_count or none");
}

}  // namespace gprodom::gpr
