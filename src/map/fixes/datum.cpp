#include "map/fixes/datum.h"

#include <GeographicLib/LocalCartesian.hpp>

namespace gprodom {
namespace {

GeographicLib::LocalCartesian plane_at(const Geodetic& origin) {
  return {origin.x(), origin.y(), origin.z()};
}

}  // namespace

Eigen::Vector3d Datum::to_site(const Geodetic& place) const {
  Eigen::Vector3d in_site;
  plane_at(origin_).Forward(place.x(), place.y(), place.z(), in_site.x(), in_site.y(), in_site.z());
  return in_site;
}

Geodetic Datum::to_geodetic(const Eigen::Vector3d& in_site) const {
  Geodetic place;
  plane_at(origin_).Reverse(in_site.x(), in_site.y(), in_site.z(), place.x(), place.y(), place.z());
  return place;
}

}  // namespace gprodom
