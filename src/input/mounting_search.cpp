#include "input/mounting_search.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <complex>

#include "estimation/nav_state.h"

namespace gprodom {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kMoves_mps = 0.02;
constexpr std::size_t kApart = 2;  // windows: their accelerations share none
constexpr double kKnown = 0.5;     // rad; accelerations tell something from here on
constexpr double kEnough = 0.02;   // rad; what is left is less than an axis is misaligned
// Windows, as if so many had shown that the axes found earlier have no slope.
constexpr double kLevelled = 20.0;
constexpr std::size_t kAngles = 720;  // of the posterior
// Before it shows: standard deviation of the error of a mean acceleration (a degree of tilt), known
// as if from so many values. Between 0.1 and 0.4, and with 1 value, the yaw of all recordings comes
// within the same deviations.
constexpr double kError = 0.1, kValues = 1.0;  // m/s^2

Vector2d turned(const Vector2d& v, double angle) { return Eigen::Rotation2Dd(angle) * v; }

double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace

Eigen::Matrix3d levelled(const Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()).toRotationMatrix();
}

void MountingSearch::add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
                         const Vector3d& gyro_bias) {
  constexpr std::size_t kNeeded = kApart + 3;
  if (is_certain() || !windows_.add(steps, wheel_m, gyro_bias)) return;
  const std::vector<MountingWindow>& w = windows_.complete();
  if (w.size() < kNeeded) return;
  bool known = true, moves = false;
  for (const MountingWindow& window : w) {
    known = known && window.wheel;
    moves = moves || std::abs(window.speed) > kMoves_mps;
  }
  if (known && moves) {
    const MountingAccelerations old = accelerations(w[0], w[1], w[2]),
                                now = accelerations(w[kApart], w[kApart + 1], w[kApart + 2]);
    const Vector2d wheel = now.by_wheel - old.by_wheel, imu = now.by_imu - old.by_imu;
    product_ += Vector2d(imu.dot(wheel), imu.x() * wheel.y() - imu.y() * wheel.x());
    squares_ += imu.squaredNorm() + wheel.squaredNorm();
    count_ += 1.0;
    by_wheel_ += now.by_wheel;
    by_imu_ += now.by_imu;
    moving_ += 1.0;
    weigh();
  }
  windows_.forget_oldest(1);
}

// The posterior of the yaw. Errors are normal with an unknown variance, of which the prior is an
// inverse chi squared: integrated out, the density is that of Student. An acceleration enters two
// differences, each with the errors of two: hence a quarter of the squares.
void MountingSearch::weigh() {
  const double size = product_.norm(), angle = std::atan2(product_.y(), product_.x());
  std::array<double, kAngles> logs;
  const auto of = [](std::size_t k) { return 2 * M_PI * (static_cast<double>(k) / kAngles - 0.5); };
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < kAngles; ++k) {
    const double left = 0.25 * (squares_ - 2 * size * std::cos(of(k) - angle));
    logs[k] = -0.5 * (count_ + kValues) * std::log(left + kValues * kError * kError);
    if (earlier_sigma_)
      logs[k] -= 0.5 * std::pow(wrapped(of(k) - earlier_yaw_) / *earlier_sigma_, 2);
    most = std::max(most, logs[k]);
  }
  std::complex<double> mean = 0.0;
  double sum = 0.0, square = 0.0;
  for (std::size_t k = 0; k < kAngles; ++k) {
    logs[k] = std::exp(logs[k] - most);
    sum += logs[k];
    mean += std::polar(logs[k], of(k));
  }
  yaw_ = std::arg(mean);
  for (std::size_t k = 0; k < kAngles; ++k) square += logs[k] * std::pow(wrapped(of(k) - yaw_), 2);
  sigma_ = std::sqrt(square / sum);
}

std::optional<Eigen::Matrix3d> MountingSearch::take_turn() {
  if (sigma_ > std::min(kKnown, 0.5 * taken_sigma_)) return std::nullopt;
  taken_sigma_ = sigma_;
  const Vector2d by_slope = (by_imu_ - turned(by_wheel_, -yaw_)) / moving_;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw_, Vector3d::UnitZ()) *
                               levelled(Vector3d(by_slope.x(), by_slope.y(), kStandardGravity));
  product_ = turned(product_, -yaw_);
  by_imu_ = by_wheel_;  // there is no slope left
  earlier_yaw_ = wrapped(earlier_yaw_ - yaw_);
  yaw_ = 0.0;
  windows_ = {};
  return turn;
}

bool MountingSearch::is_certain() const { return sigma_ < kEnough; }

void MountingSearch::resume(double yaw_sigma) {
  if (yaw_sigma > kKnown) return;
  earlier_sigma_ = sigma_ = taken_sigma_ = yaw_sigma;
  moving_ = kLevelled;
}

}  // namespace gprodom
