#include "map/merge/datum_join.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "map/fixes/anchor.h"
#include "map/search_window.h"

namespace gprodom {
namespace {

using Eigen::Matrix3d;

// Covariance of (x, y, yaw) in site of a place of a map: of the map as a whole, and of the path of
// the antenna in it.
Matrix3d covariance_at(const MapDatum& datum, const Eigen::Vector2d& in_site) {
  Matrix3d covariance = carried(planar_block(datum.covariance), in_site - datum.pose.p);
  covariance.diagonal().head<2>().array() += kPathError * kPathError;
  return covariance;
}

const MapDatum* find_datum(const GroundMap& ground, int map) {
  const auto found = ground.datums.find(map);
  return found == ground.datums.end() ? nullptr : &found->second;
}

// The last place of a map; there is one.
const KnownPlace& last_of(const GroundMap& ground, int map) {
  return *std::find_if(ground.places.rbegin(), ground.places.rend(),
                       [map](const KnownPlace& place) { return place.map == map; });
}

std::optional<JoinedTracks> join_to(const GroundMap& ground, int joining, int into,
                                    const MapDatum& here, const MapDatum& there) {
  JoinedTracks joined;
  const auto take = [&](int map, const PlanarPose& by) {
    for (KnownPlace place : ground.places) {
      if (place.map != map) continue;
      place.pose = compose(by, place.pose);
      place.map = into;
      joined.places.push_back(place);
    }
  };
  take(into, {});
  take(joining, between(there.pose, here.pose));
  for (const KnownPlace& place : joined.places) {
    const Eigen::Vector2d in_site = compose(there.pose, place.pose).p;
    const Matrix3d covariance = covariance_at(here, in_site) + covariance_at(there, in_site);
    if (!(std::sqrt(covariance.topLeftCorner<2, 2>().trace()) <= kLostSigma)) return std::nullopt;
    joined.end.pose = place.pose;
    joined.end.covariance.topLeftCorner<3, 3>() = turned(covariance, -there.pose.yaw);
  }
  return joined;
}

}  // namespace

std::optional<JoinedTracks> join_by_datum(const GroundMap& ground, int joining, int begin) {
  const MapDatum* own = find_datum(ground, joining);
  if (!own) return std::nullopt;
  for (const auto& [into, there] : ground.datums) {
    if (into >= begin || !ground.holds(into)) continue;
    const auto here = in_site_of(*own, there.origin);
    if (!here) continue;
    if (auto joined = join_to(ground, joining, into, *here, there)) return joined;
  }
  return std::nullopt;
}

// As a revisit is left out that contradicts the others.
bool DatumCheck::agrees() const { return deviations <= PoseGraphOptions{}.drop_beyond; }

std::optional<DatumCheck> check_datums(const GroundMap& ground, int joining,
                                       const JoinedTracks& joined) {
  const MapDatum* own = find_datum(ground, joining);
  const MapDatum* there = find_datum(ground, joined.places.front().map);
  if (!own || !there) return std::nullopt;
  const auto here = in_site_of(*own, there->origin);
  if (!here) return std::nullopt;
  const PlanarPose by_datum = compose(here->pose, last_of(ground, joining).pose);
  const PlanarPose by_ground = compose(there->pose, joined.end.pose);
  const Matrix3d covariance = covariance_at(*here, by_datum.p) +
                              covariance_at(*there, by_ground.p) +
                              turned(joined.end.covariance.topLeftCorner<3, 3>(), there->pose.yaw);
  Eigen::Vector3d off;
  off << by_ground.p - by_datum.p, wrapped(by_ground.yaw - by_datum.yaw);
  return DatumCheck{off.head<2>().norm(), std::sqrt(off.dot(covariance.inverse() * off))};
}

std::optional<MapDatum> datum_of_other(const GroundMap& ground, int joining,
                                       const JoinedTracks& joined) {
  const MapDatum* own = find_datum(ground, joining);
  if (!own) return std::nullopt;
  MapDatum there = *own;
  const PlanarPose end = compose(own->pose, last_of(ground, joining).pose);
  there.pose = compose(end, between(joined.end.pose, {}));
  const Matrix3d at_end = covariance_at(*own, end.p) +
                          turned(joined.end.covariance.topLeftCorner<3, 3>(), there.pose.yaw);
  set_planar_block(carried(at_end, there.pose.p - end.p), there.covariance);
  return there;
}

}  // namespace gprodom
