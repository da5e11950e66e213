#include "motion/drive_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom {

namespace {

// Half of the squares of normal errors of unit variance are below this. A slip is among the others.
constexpr double kMedian = 0.455;

// Over a minute the variance over a second is known to a quarter: what is more than 1.5 times the
// wheel's noise is the accelerations'.
constexpr double kSignificant = 1.5;

// State intervals: a second and more. Tilt and flicker make an error grow faster than white noise
// does, and what counts is how far it has come where speeds change, within seconds.
constexpr std::size_t kLongTimes[] = {5, 10, 25};

}  // namespace

void DriveNoise::add(const StateInput& input, const NavState& at) {
  const TimeNs begin = std::exchange(end_, input.time);
  double v = 0, p = 0, dt = 0, wheel_m = 0;
  Eigen::Quaterniond q = at.q_odom_body;
  bool bridged = false;
  for (const MotionStep& step : input.steps) {
    const Eigen::Vector3d rate = step.angular_velocity - at.gyro_bias;
    q = (q * so3::exp(rate * step.dt)).normalized();
    const Eigen::Vector3d up = q.conjugate() * Eigen::Vector3d(0, 0, gravity_);
    const double forwards = (step.acceleration - at.accel_bias - up).x();
    p += v * step.dt + 0.5 * forwards * step.dt * step.dt;
    v += forwards * step.dt;
    dt += step.dt;
    wheel_m += step.wheel_m / at.wheel_scale;
    bridged |= step.bridged;
  }
  const bool goes_on =
      at.time == begin && input.has_wheel && !input.wheel_contradicted && !bridged && dt > 0;
  const bool drives = goes_on && std::abs(wheel_m) > kSlowest * dt;
  if (!drives) {
    last_dt_ = 0;
    return;
  }
  if (last_dt_ > 0) {
    // The mean speed of this interval less that of the last, by the wheel and by the IMU.
    const double by_imu = last_v_ - last_p_ / last_dt_ + p / dt;
    const double by_wheel = wheel_m / dt - last_wheel_m_ / last_dt_;
    runs_.back().drift_mps.push_back(runs_.back().drift_mps.back() + by_imu - by_wheel);
    ++kept_;
    while (kept_ > kMost) {
      Run& oldest = runs_.front();
      oldest.drift_mps.pop_front();
      --kept_;
      if (oldest.drift_mps.size() < 2 && runs_.size() > 1) {
        kept_ -= oldest.drift_mps.size();
        runs_.pop_front();
      }
    }
    learn();
  } else {
    runs_.push_back({{0.0}});
    ++kept_;
  }
  last_wheel_m_ = wheel_m;
  last_v_ = v;
  last_p_ = p;
  last_dt_ = dt;
}

double DriveNoise::variance(std::size_t m) const {
  std::vector<double> squares;
  for (const Run& run : runs_) {
    const auto& s = run.drift_mps;
    for (std::size_t k = 0; k + 2 * m < s.size(); ++k)
      squares.push_back(std::pow(s[k + 2 * m] - 2 * s[k + m] + s[k], 2));
  }
  if (squares.size() < kFewest) return 0.0;
  const auto median = squares.begin() + static_cast<long>(squares.size() / 2);
  std::nth_element(squares.begin(), median, squares.end());
  return *median / kMedian;
}

// Noise of density d makes the speed err by d^2 T in a time T: the difference of two such errors
// has 2 d^2 T. The wheel's speed enters with weights 1, -2, 1.
void DriveNoise::learn() {
  const double in_short = variance(1);
  if (in_short <= 0) return;
  double density2 = 0;
  known_ = false;
  for (const std::size_t m : kLongTimes) {
    const double in_long = variance(m);
    known_ = in_long > 0;
    if (in_long > kSignificant * in_short)
      density2 =
          std::max(density2, (in_long - in_short) / (2.0 * static_cast<double>(m - 1) * last_dt_));
  }
  accel_density_ = std::sqrt(density2);
  const double wheel_mps2 = std::max(0.0, in_short - 2.0 * density2 * last_dt_) / 6.0;
  increment_sigma_m_ = std::sqrt(wheel_mps2) * last_dt_;
}

}  // namespace gprodom
