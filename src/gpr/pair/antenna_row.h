// Which of the configured antennas are the front and the rear one of a pair in a row.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gprodom/config.h"

namespace gprodom::gpr {

struct AntennaRow {
  struct Antenna {
    int id = 0;
    Eigen::Vector3d lever = Eigen::Vector3d::Zero();  // m, of its centre in body
  };
  Antenna front, rear;

  double distance_m() const { return front.lever.x() - rear.lever.x(); }  // along the track
};

// Whether they see different ground: one is so far to the left or right of the other.
bool are_abreast(const Eigen::Vector3d& one, const Eigen::Vector3d& other);

// Nothing without two antennas far enough apart along the track.
std::optional<AntennaRow> antenna_row(const GprConfig& config);

}  // namespace gprodom::gpr
