// The origin of `site` on the Earth: site is the plane of east, north and up there.
#pragma once

#include <Eigen/Core>

namespace gprodom {

// Latitude, longitude (deg) and height above the ellipsoid (m), WGS 84.
using Geodetic = Eigen::Vector3d;

constexpr double kFarFromDatum = 2e5;  // m; no site reaches further from its datum

class Datum {
 public:
  explicit Datum(const Geodetic& origin) : origin_(origin) {}

  const Geodetic& origin() const { return origin_; }

  // East, north, up (m), and back.
  Eigen::Vector3d to_site(const Geodetic& place) const;
  Geodetic to_geodetic(const Eigen::Vector3d& in_site) const;

 private:
  Geodetic origin_;
};

}  // namespace gprodom
