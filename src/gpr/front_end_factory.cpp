#include "gpr/front_end_factory.h"

#include "gpr/motion/motion_front_end.h"
#include "gpr/motion/stationarity.h"
#include "gpr/sequential/sequential.h"

namespace gprodom::gpr {

std::unique_ptr<FrontEnd> make_front_end(const GprConfig& config) {
  switch (config.front_end) {
    case FrontEndKind::kMotion:
      return std::make_unique<MotionFrontEnd>(config);
    case FrontEndKind::kStationarity:
      return std::make_unique<StationarityFrontEnd>();
    case FrontEndKind::kSfm:
    case FrontEndKind::kBscan:
    case FrontEndKind::kDec:
    case FrontEndKind::kSalient:
    case FrontEndKind::kTraceCount:
      return std::make_unique<SequentialFrontEnd>(config);
    case FrontEndKind::kNone:
      break;
  }
  return nullptr;
}

}  // namespace gprodom::gpr
