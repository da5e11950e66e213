// How the frame of a map lies in `site`: what a tie by fixes leaves in the map file, and how two
// such ties are compared. docs/anchors.md, "What the map keeps".
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/graph/pose_graph.h"
#include "map/fixes/datum.h"

namespace gprodom {

struct MapDatum {
  PlanarPose pose;  // of the map's frame in site
  double z = 0.0;   // m; of the map's origin in site
  // Of x, y, z (m^2) and yaw (rad^2) of the frame as a whole, axes of site.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  std::optional<Geodetic> origin;  // of site; nothing: no message or setting has told it
};

// The covariance of (x, y, yaw) at another place of what is rigid: `way` leads there, m, in the
// axes of the covariance.
Eigen::Matrix3d carried(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& way);
// The same covariance in other axes, in which its own are turned by `yaw`, rad.
Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, double yaw);

// The datum in the site with that origin. Nothing where only one of the two is known, or where they
// are too far apart for one site. Two sites without origin are taken for the same.
std::optional<MapDatum> in_site_of(const MapDatum& datum, const std::optional<Geodetic>& origin);

// Where the map's origin lies on the Earth, and its x axis (rad, from east there, to the left).
// Nothing without an origin of site.
struct FrameOnEarth {
  Geodetic origin;
  double yaw = 0.0;
};
std::optional<FrameOnEarth> on_earth(const MapDatum& datum);

// How fixes move a map, as a whole, from where it was known to lie in site.
struct RigidTie {
  PlanarPose by;  // in site: moves each place of the map
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  // of (x, y, yaw) at the origin of site, after that motion
  double worst = 0.0;           // largest innovation of a fix, in standard deviations
};
// Standard deviations (m, m, rad) of a place in site where nothing is known: far beyond what fixes
// leave.
inline const Eigen::Vector3d kNothingKnown(1e4, 1e4, 3.0);

// What was known before: covariances of (x, y, yaw) at the origin of site.
struct KnownTie {
  Eigen::Matrix3d map, track;  // how the map lies in site, and how the track lies in the map
};
// places: of the fixes, as the map has them in site. The errors of fixes that last are followed
// (FixEdge::kept); those of the odometry between fixes are not.
RigidTie tie_rigidly(const std::vector<FixEdge>& fixes, const std::vector<PlanarPose>& places,
                     const std::optional<KnownTie>& known);

}  // namespace gprodom
