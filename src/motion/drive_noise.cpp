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
  double v = 0, p = 0, dt = 0, wheel_m = 0, sideways = 0;
  Eigen::Quaterniond q = at.q_odom_body;
  bool bridged = false;
  for (const MotionStep& step : input.steps) {
    const Eigen::Vector3d rate = step.angular_velocity - at.gyro_bias;
    q = (q * so3::exp(rate * step.dt)).normalized();
    const Eigen::Vector3d up = q.conjugate() * Eigen::Vector3d(0, 0, gravity_);
    const Eigen::Vector3d acceleration = step.acceleration - at.accel_bias - up;
    const double forwards = acceleration.x();
    // Without side slip there is the centripetal acceleration, and no other.
    sideways += acceleration.y() * step.dt - rate.z() * step.wheel_m / at.wheel_scale;
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
    delay_.interrupt();
    return;
  }
  if (last_dt_ > 0) {
    // The mean speed of this interval less that of the last, by the wheel and by the IMU.
    const double by_imu = last_v_ - last_p_ / last_dt_ + p / dt;
    const double by_wheel = wheel_m / dt - last_wheel_m_ / last_dt_;
    delay_.add(by_imu, by_wheel, dt);
    runs_.back().drift_mps.push_back(runs_.back().drift_mps.back() +
                                     Eigen::Vector2d(by_imu - by_wheel, sideways));
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
    runs_.push_back({{Eigen::Vector2d::Zero()}});
    ++kept_;
  }
  last_wheel_m_ = wheel_m;
  last_v_ = v;
  last_p_ = p;
  last_dt_ = dt;
}

double DriveNoise::accel_density_of_half_second() const {
  return kept_ < kHalfMinute ? 0.0 : accel_density_of_half_second_;
}

// From the median of the squares, forwards and sideways; 0 where there are too few.
Eigen::Array2d DriveNoise::variance(std::size_t m) const {
  std::vector<double> squares[2];
  for (const Run& run : runs_) {
    const auto& s = run.drift_mps;
    for (std::size_t k = 0; k + 2 * m < s.size(); ++k)
      for (int axis = 0; axis < 2; ++axis)
        squares[axis].push_back(std::pow(s[k + 2 * m][axis] - 2 * s[k + m][axis] + s[k][axis], 2));
  }
  if (squares[0].size() < kFewest) return Eigen::Array2d::Zero();
  Eigen::Array2d variance;
  for (int axis = 0; axis < 2; ++axis) {
    const auto median = squares[axis].begin() + static_cast<long>(squares[axis].size() / 2);
    std::nth_element(squares[axis].begin(), median, squares[axis].end());
    variance[axis] = *median / kMedian;
  }
  return variance;
}

// Noise of density d makes the speed err by d^2 T in a time T: the difference of two such errors
// has 2 d^2 T. The wheel's speed enters with weights 1, -2, 1.
void DriveNoise::learn() {
  const Eigen::Array2d in_short = variance(1);
  if (in_short[0] <= 0) return;
  Eigen::Array2d density2 = Eigen::Array2d::Zero();
  for (const std::size_t m : kLongTimes) {
    const Eigen::Array2d in_long = variance(m);
    const Eigen::Array2d grown =
        (in_long - in_short) / (2.0 * static_cast<double>(m - 1) * last_dt_);
    density2 = (in_long > kSignificant * in_short).select(density2.max(grown), density2);
    if (m == kLongTimes[0]) accel_density_of_half_second_ = std::sqrt(density2[0]);
  }
  accel_density_ = density2.sqrt();
  const double wheel_mps2 = std::max(0.0, in_short[0] - 2.0 * density2[0] * last_dt_) / 6.0;
  increment_sigma_m_ = std::sqrt(wheel_mps2) * last_dt_;
}

}  // namespace gprodom
