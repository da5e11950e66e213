// Checks that the constants of gprodom/types.h are equal to those of the message types in
// lcmtypes/.
#include "gprodom/position_fix.h"
#include "gprodom/types.h"
#include "lcmtypes/gprodom/displacement_t.hpp"
#include "lcmtypes/gprodom/odometry_t.hpp"
#include "lcmtypes/gprodom/position_fix_t.hpp"
#include "lcmtypes/gprodom/sfm_t.hpp"
#include "lcmtypes/gprodom/status_t.hpp"

namespace gprodom {

template <class Enum>
constexpr bool is(Enum ours, int sent) {
  return static_cast<int>(ours) == sent;
}

static_assert(is(DisplacementKind::kSequential, displacement_t::SEQUENTIAL));
static_assert(is(DisplacementKind::kMotion, displacement_t::MOTION));
static_assert(is(DisplacementKind::kRevisit, displacement_t::REVISIT));
static_assert(is(DisplacementKind::kExternal, displacement_t::EXTERNAL));

static_assert(is(FixFrame::kSite, position_fix_t::SITE));
static_assert(is(FixFrame::kGeodetic, position_fix_t::GEODETIC));

static_assert(is(FixQuality::kNone, position_fix_t::NONE));
static_assert(is(FixQuality::kSingle, position_fix_t::SINGLE));
static_assert(is(FixQuality::kFloat, position_fix_t::FLOAT));
static_assert(is(FixQuality::kFixed, position_fix_t::FIXED));
static_assert(is(FixQuality::kSurveyed, position_fix_t::SURVEYED));

static_assert(is(kStanding, odometry_t::STANDING));
static_assert(is(kSlipping, odometry_t::SLIPPING));
static_assert(is(kNoWheel, odometry_t::NO_WHEEL));
static_assert(is(kNoRadar, odometry_t::NO_RADAR));
static_assert(is(kImuGap, odometry_t::IMU_GAP));
static_assert(is(kSolverFailed, odometry_t::SOLVER_FAILED));
static_assert(is(kWheelFast, odometry_t::WHEEL_FAST));
static_assert(is(kWheelSlow, odometry_t::WHEEL_SLOW));
static_assert(is(kLeftSlips, odometry_t::LEFT_SLIPS));
static_assert(is(kRightSlips, odometry_t::RIGHT_SLIPS));
static_assert(is(kImmobilised, odometry_t::IMMOBILISED));

static_assert(is(kMaxFeatureLevel, sfm_t::MAX_LEVEL));

static_assert(is(HealthLevel::kOk, status_t::OK));
static_assert(is(HealthLevel::kDegraded, status_t::DEGRADED));
static_assert(is(HealthLevel::kFailed, status_t::FAILED));

}  // namespace gprodom
