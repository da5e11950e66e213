#include "gpr/pair/antenna_row.h"

#include <algorithm>
#include <cmath>

namespace gprodom::gpr {

namespace {

// m. Antennas closer together see the same ground at the same time: their footprints overlap.
constexpr double kLeastDistance = 0.1;

// m, a third of a usual footprint. Antennas less far aside see the same ground.
constexpr double kLeastAside = 0.05;

}  // namespace

bool are_abreast(const Eigen::Vector3d& one, const Eigen::Vector3d& other) {
  return std::abs(one.y() - other.y()) >= kLeastAside;
}

std::optional<AntennaRow> antenna_row(const GprConfig& config) {
  if (!config.enabled || config.antennas.size() < 2) return std::nullopt;
  const auto by_x = [](const auto& a, const auto& b) { return a.second.x() < b.second.x(); };
  const auto [rear, front] =
      std::minmax_element(config.antennas.begin(), config.antennas.end(), by_x);
  const AntennaRow row{{front->first, front->second}, {rear->first, rear->second}};
  return row.distance_m() < kLeastDistance ? std::nullopt : std::optional(row);
}

}  // namespace gprodom::gpr
