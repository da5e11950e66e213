#include "motion/rest/wheel_tick.h"

#include <cmath>

#include "estimation/initializer.h"
#include "motion/rest/standstill.h"

namespace gprodom {

namespace {

// Standard deviations of the noise of a mean.
constexpr double kBeyondNoise = 6.0;

}  // namespace

// A reading is up to a tick behind, equally likely anything up to that: a variance of a twelfth of
// the square. Two increments share a reading, so that each has one of its own.
void WheelTick::set_resolution(double resolution_m) {
  sigma_m_ = resolution_m / std::sqrt(12.0);
  longest_ = from_seconds(resolution_m / kRestingWheel);
}

bool WheelTick::hides_motion(const StateResult& newest, const std::vector<ImuSample>& samples,
                             double accel_density, TimeNs to) {
  if (longest_ < from_seconds(kStillFor_s)) return false;
  if (newest.standing && samples.size() > 1) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : samples) force += sample.acceleration;
    force /= static_cast<double>(samples.size());
    const NavState& x = newest.state;
    const Eigen::Vector3d at_rest =
        x.R_odom_body().transpose() * Eigen::Vector3d(0, 0, kStandardGravity) + x.accel_bias;
    const double seconds = to_seconds(samples.back().time - samples.front().time);
    const double sigma = accel_density / std::sqrt(seconds);
    if ((force - at_rest).norm() > kBeyondNoise * sigma) set_off_ = to;
  }
  return set_off_ >= 0 && to < set_off_ + longest_;
}

}  // namespace gprodom
