// Positions from outside in messages of ROS. What a message's status and covariance mean is as in
// scripts/gprodom/fixes/trust.py, by which bags are converted.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "conversions.h"
#include "gprodom/position_fix.h"

namespace gprodom::ros_shared {

inline constexpr double kCentimetres = 0.05;  // m, horizontal: ambiguities are fixed

// One standard deviation of a coordinate where nothing better is told: of the horizontal axes, and
// of the vertical one.
inline Eigen::Matrix3d conservative(FixQuality quality) {
  double horizontal = 5.0, vertical = 10.0;
  if (quality == FixQuality::kFloat) horizontal = 1.0, vertical = 2.0;
  if (quality == FixQuality::kFixed) horizontal = 0.05, vertical = 0.1;
  return Eigen::Vector3d(horizontal, horizontal, vertical).array().square().matrix().asDiagonal();
}

inline bool is_known(const Eigen::Matrix3d& covariance) {
  return covariance.allFinite() && covariance.diagonal().minCoeff() > 0.0;
}

// As good as the covariance says.
inline FixQuality quality_of(const Eigen::Matrix3d& covariance, bool known) {
  const double variance = covariance.diagonal().head<2>().maxCoeff();
  return known && variance <= kCentimetres * kCentimetres ? FixQuality::kFixed : FixQuality::kFloat;
}

// sensor_msgs/NavSatFix: geodetic. GBAS stands for carrier phases.
template <class NavSatFix>
PositionFix to_fix(TimeNs time, const NavSatFix& message) {
  PositionFix fix;
  fix.time = time;
  fix.frame = FixFrame::kGeodetic;
  const Eigen::Vector3d place(message.latitude, message.longitude, message.altitude);
  if (message.status.status < 0 || !place.allFinite()) return fix;  // of quality none
  fix.position = place;
  for (std::size_t i = 0; i < 9; ++i)
    fix.covariance(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) =
        message.position_covariance[i];
  const bool known = message.position_covariance_type > 0 && is_known(fix.covariance);
  constexpr int kGbas = 2;
  fix.quality =
      message.status.status >= kGbas ? quality_of(fix.covariance, known) : FixQuality::kSingle;
  if (!known) fix.covariance = conservative(fix.quality);
  return fix;
}

// geometry_msgs/PoseWithCovariance in site.
template <class PoseWithCovariance>
PositionFix to_site_fix(TimeNs time, const PoseWithCovariance& message) {
  PositionFix fix;
  fix.time = time;
  const Eigen::Vector3d place = vector(message.pose.position);
  if (!place.allFinite()) return fix;
  fix.position = place;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      fix.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          message.covariance[6 * i + j];
  const bool known = is_known(fix.covariance);
  fix.quality = quality_of(fix.covariance, known);
  if (!known) fix.covariance = conservative(fix.quality);
  const Eigen::Quaterniond turn = rotation(message.pose.orientation);
  const double sigma = std::sqrt(std::max(message.covariance[35], 0.0));
  constexpr double kWidest = 1.5707963267948966;  // rad; more tells no heading
  if (std::abs(turn.norm() - 1.0) < 0.01 && sigma > 0.0 && sigma < kWidest) {
    const Eigen::Vector3d ahead = turn * Eigen::Vector3d::UnitX();
    fix.has_heading = true;
    fix.heading = std::atan2(ahead.y(), ahead.x());
    fix.heading_sigma = sigma;
  }
  return fix;
}

}  // namespace gprodom::ros_shared
