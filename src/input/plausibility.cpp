#include "input/plausibility.h"

#include <algorithm>
#include <cmath>

#include "gpr/filter/details_retention.h"

namespace gprodom {

std::string fault(const ImuSample& s, const Config& config) {
  if (!s.acceleration.allFinite() || !s.angular_velocity.allFinite()) return "value not finite";
  if (s.acceleration.norm() > config.imu.max_acceleration) return "beyond imu.max_acceleration";
  if (s.angular_velocity.norm() > config.imu.max_angular_velocity)
    return "beyond imu.max_angular_velocity";
  return {};
}

std::string fault(const WheelSample& s, const Config& /*config*/) {
  if (!std::isfinite(s.distance_m)) return "distance not finite";
  if (!(s.resolution_m >= 0 && s.resolution_m < 1e3)) return "resolution not within 0 to 1000 m";
  return std::abs(s.distance_m) < 1e9 ? "" : "distance beyond a million kilometres";
}

std::string fault(const WheelsSample& s, const Config& config) {
  const std::string left = fault(WheelSample{s.time, s.left_m, s.resolution_m}, config);
  return left.empty() ? fault(WheelSample{s.time, s.right_m, s.resolution_m}, config) : left;
}

std::string fault(const GprTrace& s, const Config& config) {
  if (s.samples.size() < 32) return "fewer than 32 samples";
  if (s.samples.size() > 16384) return "more than 16384 samples";
  if (!(s.sample_interval_s >= 1e-12 && s.sample_interval_s * config.gpr.filter.band_low < 0.5))
    return "sample interval not between 1 ps and half a period of gpr.filter.band_low";
  if (s.sample_interval_s > 0.5 * gpr::FilterOptions::kBandLength)
    return "sample interval longer than half of the band-pass filter";
  if (!(std::abs(s.time_zero_s) < 1e-3)) return "time zero not within 1 ms";
  const bool finite =
      std::all_of(s.samples.begin(), s.samples.end(), [](float x) { return std::isfinite(x); });
  return finite ? "" : "sample not finite";
}

// A sigma of 0 is how some receivers say that they do not know it.
std::string fault(const PositionFix& s, const Config& /*config*/) {
  if (s.quality == FixQuality::kNone) return "quality none: no position";
  if (!s.position.allFinite() || !s.covariance.allFinite()) return "value not finite";
  const Eigen::Vector3d variances = s.covariance.diagonal();
  if (!(variances.minCoeff() > 0 && variances.maxCoeff() < 1e8))
    return "standard deviation not above 0 and below 10 km";
  if (s.has_heading && !(std::abs(s.heading) < 100 && s.heading_sigma > 0 && s.heading_sigma < 10))
    return "heading or its sigma out of range";
  if (s.frame == FixFrame::kSite) return s.position.norm() < 1e7 ? "" : "position beyond 10 000 km";
  if (!(std::abs(s.position.x()) <= 90))
    return "latitude beyond 90 degrees: swapped with longitude?";
  if (!(std::abs(s.position.y()) <= 360)) return "longitude beyond 360 degrees";
  return std::abs(s.position.z()) < 1e5 ? "" : "height beyond 100 km";
}

std::string fault(const Displacement& s, const Config& /*config*/) {
  if (!std::isfinite(s.distance_m) || !std::isfinite(s.sigma_m) || s.sigma_m <= 0)
    return "distance or sigma not finite and positive";
  if (std::abs(s.distance_m) > 1e6 || s.sigma_m < 1e-6) return "impossible distance or sigma";
  if (!(std::abs(s.lateral_m) < 1e6) || !std::isfinite(s.lateral_sigma_m))
    return "lateral or its sigma not finite";
  if (!std::isfinite(s.scale) || !std::isfinite(s.score)) return "scale or score not finite";
  return s.from < s.to ? "" : "utime_from not before utime_to";
}

}  // namespace gprodom
