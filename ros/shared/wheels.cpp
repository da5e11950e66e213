#include "wheels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace gprodom::ros_shared {

WheelSample WheelOdometry::add(TimeNs time, const Eigen::Vector3d& position,
                               const Eigen::Quaterniond& orientation) {
  double step_m = 0.0;
  if (position_) {
    const Eigen::Vector3d step = position - *position_;
    const Eigen::Quaterniond halfway = orientation_.slerp(0.5, orientation);
    step_m = std::copysign(step.norm(), step.dot(halfway * Eigen::Vector3d::UnitX()));
  }
  const double sum_m = distance_m_ + step_m;
  if (!std::isfinite(sum_m) || !position.allFinite() || !orientation.coeffs().allFinite())
    return {time, std::numeric_limits<double>::quiet_NaN()};
  position_ = position;
  orientation_ = orientation;
  distance_m_ = sum_m;
  return {time, distance_m_};
}

double Integral::add(TimeNs time, double rate) {
  const double sum = last_ ? sum_ + 0.5 * (rate_ + rate) * to_seconds(time - *last_) : sum_;
  if (!std::isfinite(rate) || !std::isfinite(sum)) return std::numeric_limits<double>::quiet_NaN();
  last_ = time;
  rate_ = rate;
  sum_ = sum;
  return sum_;
}

WheelsSample to_wheels(const WheelSample& middle, double turned_rad, double track_m) {
  const double half_m = 0.5 * track_m * turned_rad;
  return {middle.time, middle.distance_m - half_m, middle.distance_m + half_m};
}

std::optional<WheelSample> to_sample(TimeNs time, const std::vector<std::string>& names,
                                     const std::vector<double>& positions, const std::string& joint,
                                     double radius_m) {
  const auto found = std::find(names.begin(), names.end(), joint);
  const auto index = static_cast<std::size_t>(found - names.begin());
  if (index >= names.size() || index >= positions.size()) return std::nullopt;
  return WheelSample{time, positions[index] * radius_m};
}

std::optional<WheelsSample> to_sample(TimeNs time, const std::vector<std::string>& names,
                                      const std::vector<double>& positions,
                                      const std::vector<std::string>& left,
                                      const std::vector<std::string>& right, double radius_m) {
  WheelsSample sample{time, 0.0, 0.0};
  const auto add = [&](const std::vector<std::string>& joints, double& side_m) {
    for (const std::string& joint : joints) {
      const auto wheel = to_sample(time, names, positions, joint, radius_m);
      if (!wheel) return false;
      side_m += wheel->distance_m / static_cast<double>(joints.size());
    }
    return true;
  };
  if (!add(left, sample.left_m) || !add(right, sample.right_m)) return std::nullopt;
  return sample;
}

std::vector<std::string> names_by_commas(const std::string& list) {
  std::vector<std::string> found;
  std::istringstream in(list);
  for (std::string each; std::getline(in, each, ',');)
    if (!each.empty()) found.push_back(each);
  return found;
}

}  // namespace gprodom::ros_shared
