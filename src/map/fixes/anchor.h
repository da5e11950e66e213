// A fix at its place on the path, and how two of them are compared.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gprodom/position_fix.h"
#include "map/map_path.h"

namespace gprodom {

struct Anchor {
  MapPath::Mark mark;  // the robot then
  Eigen::Vector3d p;   // of the antenna in site, m
  Eigen::Matrix3d covariance;
  Eigen::Vector3d lever_arm;  // of the antenna in body
  int antenna = 0;
  FixQuality quality = FixQuality::kNone;
  std::optional<double> heading;  // rad
  double heading_sigma = 0.0;
};

// Time for which the error of a fix lasts, s. Of code solutions minutes, by the atmosphere and by
// multipath of a robot that is slow; of fixed ambiguities what multipath leaves of the phase.
double error_lasts(FixQuality quality);

// Share of the information of a fix that it has beside the one before it, `seconds` earlier. The
// sum over a long time t is that of 1 + t / (2 T) independent fixes, with T the time for which the
// errors last.
double own_share(FixQuality quality, double seconds);

// The wheel's scale as known now.
struct ScaleKnown {
  double scale = 1.0, sigma = 0.0;
};

// Whether the antennas of two fixes, or of three in the order of time, lie as the odometry between
// them says: distance, and for three also the angle. Both hold in any frame, so that nothing need
// be known of how the track lies in site.
bool agree(const Anchor& a, const Anchor& b, const ScaleKnown& scale);
bool agree(const Anchor& a, const Anchor& b, const Anchor& c, const ScaleKnown& scale);

}  // namespace gprodom
