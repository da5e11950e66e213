// A position from outside (GNSS, total station, surveyed marker), as position_fix_t has it. The
// values of the enums are those of lcmtypes/, which src/io/lcm_constants.cpp checks.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "gprodom/types.h"

namespace gprodom {

// What the coordinates of a fix are: x, y, z in `site` (m); or latitude and longitude (deg) and
// height above the ellipsoid (m), WGS 84.
enum class FixFrame : std::int8_t { kSite = 0, kGeodetic = 1 };

enum class FixQuality : std::int8_t {
  kNone = 0,     // no position
  kSingle = 1,   // GNSS alone or with code corrections
  kFloat = 2,    // carrier phases, ambiguities not fixed
  kFixed = 3,    // carrier phases, ambiguities fixed
  kSurveyed = 4  // a total station, or a marker of known position
};

// A position from outside, of an antenna, a prism or a marker at a known place on the robot.
struct PositionFix {
  TimeNs time = 0;
  FixFrame frame = FixFrame::kSite;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // m^2; site axes, or east, north, up
  FixQuality quality = FixQuality::kNone;
  std::int32_t antenna_id = 0;
  bool has_heading = false;
  double heading = 0.0;        // rad; of body x, counter-clockwise from x of site (east)
  double heading_sigma = 0.0;  // rad
};

// Where an antenna of fixes is, as found.
struct FixAntenna {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // m; in body
  double delay = 0.0;                               // s; its fixes are of so long before
};

}  // namespace gprodom
