#include "estimation/planar_geometry.h"

#include <Eigen/Geometry>

namespace gprodom {

PlanarPose between(const PlanarPose& a, const PlanarPose& b) {
  return {Eigen::Rotation2Dd(-a.yaw) * (b.p - a.p), wrapped(b.yaw - a.yaw)};
}

PlanarPose compose(const PlanarPose& a, const PlanarPose& b_in_a) {
  return {a.p + Eigen::Rotation2Dd(a.yaw) * b_in_a.p, wrapped(a.yaw + b_in_a.yaw)};
}

PlanarPose stretched(const PlanarPose& at, const WheelWay& way, double slip) {
  return {at.p + std::expm1(slip) * way.p, at.yaw};
}

}  // namespace gprodom
