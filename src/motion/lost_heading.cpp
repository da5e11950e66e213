#include "motion/lost_heading.h"

#include <algorithm>
#include <cmath>

namespace gprodom {

void LostHeading::advance(const NavState& state, double yaw_variance) {
  const Eigen::Vector2d p = state.p_odom.head<2>();
  const double square = 1.5 - 2 * std::exp(-yaw_variance / 2) + std::exp(-2 * yaw_variance) / 2;
  if (last_m_) off_m_ += std::sqrt(std::max(square, 0.0)) * (p - *last_m_);
  last_m_ = p;
}

}  // namespace gprodom
