// The origin of `site` on the Earth: site is the plane of east, north and up there.
#pragma once

#include <Eigen/Core>

namespace gprodom {

// Latitude, longitude (deg) and height above the ellipsoid (m), WGS 84.
using Geodetic = Eigen::Vector3d;

class Datum {
 public:
  explicit Datum(const Geodetic& origin) : origin_(origin) {}

  const Geodetic& origin() const { return origin_; }

  // East, north, up (m).
  Eigen::Vector3d to_site(const Geodetic& place) const;

 private:
  Geodetic origin_;
};

}  // namespace gprodom
