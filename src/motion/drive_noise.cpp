#include "motion/drive_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/kernels/so3.h"

namespace gprodom {

namespace {

// Median of the squares of normal errors of unit variance. The median is robust against slip.
constexpr double kMedian = 0.455;

// One minute gives the variance over a second with an error of a quarter. So a variance of more
// than 1.5 times the wheel's is due to the accelerations.
constexpr double kSignificant = 1.5;

// Vibration has no preferred direction. So the density forwards over one second is at most this
// many times the one sideways: what is more is slip that changes all the time.
constexpr double kMostOverSideways = 2.0;

}  // namespace

void DriveNoise::add(const StateInput& input, const NavState& at) {
  const TimeNs begin = std::exchange(end_, input.time);
  double v = 0, p = 0, dt = 0, wheel_m = 0, sideways = 0;
  Eigen::Quaterniond q = at.q_odom_body;
  bool bridged = false;
  for (const MotionStep& step : input.steps) {
    const Eigen::Vector3d rate = step.angular_velocity - at.gyro_bias;
    q = (q * so3::exp(rate * step.dt)).normalized();
    const Eigen::Vector3d up = q.conjugate() * Eigen::Vector3d(0, 0, kStandardGravity);
    const Eigen::Vector3d acceleration = step.acceleration - at.accel_bias - up;
    const double forwards = acceleration.x();
    // Of the body's origin, from the wheel.
    const double way_m = step.wheel_m / at.wheel_scale + input.wheel_y_m * rate.z() * step.dt;
    // Without side slip the only sideways acceleration is the centripetal one.
    sideways += acceleration.y() * step.dt - rate.z() * way_m;
    p += v * step.dt + 0.5 * forwards * step.dt * step.dt;
    v += forwards * step.dt;
    dt += step.dt;
    wheel_m += way_m;
    bridged |= step.bridged;
  }
  const bool continues =
      at.time == begin && input.has_wheel && !input.wheel_contradicted && !bridged && dt > 0;
  const bool drives = continues && std::abs(wheel_m) > kSlowest * dt;
  if (!drives) {
    last_dt_ = 0;
    delay_.interrupt();
    return;
  }
  if (last_dt_ > 0) {
    // The mean speed of this interval less that of the last.
    const double by_imu = last_v_ - last_p_ / last_dt_ + p / dt;
    const double by_wheel = wheel_m / dt - last_wheel_m_ / last_dt_;
    delay_.add(by_imu, by_wheel, dt);
    append(runs_.back().back() + Eigen::Vector2d(by_imu - by_wheel, sideways));
    while (kept_ > kMost) drop_oldest();
    learn();
  } else {
    runs_.push_back({Eigen::Vector2d::Zero()});
    ++kept_;
  }
  last_wheel_m_ = wheel_m;
  last_v_ = v;
  last_p_ = p;
  last_dt_ = dt;
}

double DriveNoise::accel_density_of_one_second() const {
  return kept_ < kMinute ? 0.0 : accel_density_of_one_second_;
}

Eigen::Array2d DriveNoise::square(const Drift& s, std::size_t k, std::size_t m) {
  return (s[k + 2 * m] - 2 * s[k + m] + s[k]).array().square();
}

// Only the squares with the newest of the drift are new.
void DriveNoise::append(const Eigen::Vector2d& drift) {
  Drift& s = runs_.back();
  s.push_back(drift);
  ++kept_;
  for (Squares& squares : spans_) {
    if (s.size() <= 2 * squares.m) continue;
    const Eigen::Array2d made = square(s, s.size() - 1 - 2 * squares.m, squares.m);
    for (int axis = 0; axis < 2; ++axis) {
      auto& sorted = squares.sorted[axis];
      sorted.insert(std::upper_bound(sorted.begin(), sorted.end(), made[axis]), made[axis]);
    }
  }
}

void DriveNoise::drop_oldest() {
  Drift& s = runs_.front();
  for (Squares& squares : spans_) {
    if (s.size() <= 2 * squares.m) continue;
    const Eigen::Array2d made = square(s, 0, squares.m);
    for (int axis = 0; axis < 2; ++axis) {
      auto& sorted = squares.sorted[axis];
      const auto found = std::lower_bound(sorted.begin(), sorted.end(), made[axis]);
      if (found != sorted.end()) sorted.erase(found);
    }
  }
  s.pop_front();
  --kept_;
  if (s.size() < 2 && runs_.size() > 1) {
    kept_ -= s.size();
    runs_.pop_front();
  }
}

// From the median of the squares, forwards and sideways; 0 if there are too few.
Eigen::Array2d DriveNoise::variance(const Squares& squares) {
  const std::size_t count = squares.sorted[0].size();
  if (count < kFewest) return Eigen::Array2d::Zero();
  return Eigen::Array2d(squares.sorted[0][count / 2], squares.sorted[1][count / 2]) / kMedian;
}

// Noise of density d gives the speed a variance of d^2 T after a time T, and the difference of two
// such errors one of 2 d^2 T. The wheel's speed enters with weights 1, -2, 1.
void DriveNoise::learn() {
  const Eigen::Array2d in_short = variance(spans_[0]);
  if (in_short[0] <= 0) return;
  Eigen::Array2d density2 = Eigen::Array2d::Zero();
  for (int i = 1; i < 4; ++i) {
    const Squares& squares = spans_[i];
    const Eigen::Array2d in_long = variance(squares);
    const double growth_s = 2.0 * static_cast<double>(squares.m - 1) * last_dt_;
    const Eigen::Array2d grown = (in_long - in_short) / growth_s;
    density2 = (in_long > kSignificant * in_short).select(density2.max(grown), density2);
    if (i > 1) continue;
    // Less than this would not be noticed sideways.
    const double least = (kSignificant - 1) * in_short[1] / growth_s;
    const double most = kMostOverSideways * std::sqrt(std::max(grown[1], least));
    accel_density_of_one_second_ = std::min(std::sqrt(density2[0]), most);
  }
  accel_density_ = density2.sqrt();
  const double wheel_mps2 = std::max(0.0, in_short[0] - 2.0 * density2[0] * last_dt_) / 6.0;
  increment_sigma_m_ = std::sqrt(wheel_mps2) * last_dt_;
}

}  // namespace gprodom
