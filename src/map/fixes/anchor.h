// A fix at its place on the path, and how two of them are compared.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gprodom/position_fix.h"
#include "map/path/map_path.h"

namespace gprodom {

// m; error of the path of an antenna that is not the odometry's noise: side slip in bends, a body
// that rolls, the antenna's place.
constexpr double kPathError = 0.1;

constexpr double kDelaySigma = 0.05;  // s; receivers on a serial line stamp when a position comes

struct Anchor {
  MapPath::Mark mark;  // the robot then
  Eigen::Vector3d p;   // of the antenna in site, m
  Eigen::Matrix3d covariance;
  Eigen::Vector3d lever_arm;  // of the antenna in body
  double arm_sigma;           // of its horizontal axes, m
  int antenna = 0;
  FixQuality quality = FixQuality::kNone;
  std::optional<double> heading;  // rad
  double heading_sigma = 0.0;
};

// The error of a fix beside the track that the odometry has: a share of its variance is white; the
// rest is a Gauss-Markov process with this correlation time.
struct FixError {
  Eigen::Matrix2d covariance;  // m^2, axes of site
  double white = 1.0, lasts_s = 0.0;
};
FixError fix_error(const Anchor& anchor);
// Correlation of the lasting errors of two fixes: of one antenna and quality.
double kept_between(const Anchor& a, const Anchor& b);

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
