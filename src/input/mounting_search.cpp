#include "input/mounting_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>

#include "estimation/nav_state.h"

namespace gprodom {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kMoves_mps = 0.02;
constexpr std::size_t kApart = 2;  // windows: their accelerations share none
constexpr double kKnown = 0.35;    // rad; accelerations tell something from here on
constexpr double kEnough = 0.02;   // rad; what is left is less than an axis is misaligned
// Windows, as if so many had shown that the axes found earlier have no slope.
constexpr double kLevelled = 20.0;
// Few mount an IMU otherwise than they configure it, which they do as well as by eye (rad). Other
// axes are used if their probability is kCertain, and the configured ones are called wrong if the
// odds against them are kOdds. From kDoubt on, and until the drive speaks for them, they are not
// used: accelerations along wrong axes cost more than none. No recording with the right ones comes
// so far; at 1/3 one of twelve simulated starts in mid-drive does.
constexpr double kOtherwise = 0.01, kByEye = 0.15, kCertain = 0.99, kOdds = 9.0, kDoubt = 0.5;
// Before it shows: standard deviation of the error of a mean acceleration (half a degree of tilt),
// known as if from so many values. With 0.05 to 0.4 m/s^2 and 1 to 3 values, the yaw of recordings
// of all kinds of robots comes within the same deviations, and later where it is more.
constexpr double kError = 0.1, kValues = 1.0;  // m/s^2

Vector2d turned(const Vector2d& v, double angle) { return Eigen::Rotation2Dd(angle) * v; }

constexpr std::size_t kAngles = 720;  // of the posterior
double angle_of(std::size_t k) { return 2 * M_PI * static_cast<double>(k) / kAngles - M_PI; }

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
    const double xx = imu.x() * wheel.x(), yy = imu.y() * wheel.y(), xy = imu.x() * wheel.y(),
                 yx = imu.y() * wheel.x();
    product_ += Vector2d(xx + yy, xy - yx);
    mirrored_ += Vector2d(yy - xx, -xy - yx);
    squares_ += imu.squaredNorm() + wheel.squaredNorm();
    count_ += 1.0;
    by_wheel_ += now.by_wheel;
    by_imu_ += now.by_imu;
    moving_ += 1.0;
    weigh();
  }
  windows_.forget_oldest(1);
}

// Errors are normal with an unknown variance, of which the prior is an inverse chi squared:
// integrated out, the density is that of Student. An acceleration enters two differences, each with
// the errors of two: hence a quarter of the squares.
std::vector<double> MountingSearch::log_likelihood(const Vector2d& product) const {
  const double size = product.norm(), angle = std::atan2(product.y(), product.x());
  std::vector<double> logs(kAngles);
  for (std::size_t k = 0; k < kAngles; ++k) {
    const double left = 0.25 * (squares_ - 2 * size * std::cos(angle_of(k) - angle));
    logs[k] = -0.5 * (count_ + kValues) * std::log(left + kValues * kError * kError);
  }
  return logs;
}

// The posterior of the yaw, and whether it contradicts a configured one. An accelerometer with a
// wrong sign may look like one that is turned: as long as it does, nothing is known.
void MountingSearch::weigh() {
  std::vector<double> logs = log_likelihood(product_), mirrored = log_likelihood(mirrored_);
  const double most = *std::max_element(logs.begin(), logs.end());
  std::complex<double> mean = 0.0;
  double sum = 0.0, near = 0.0, wrong_sign = 0.0, square = 0.0, total = 0.0;
  for (std::size_t k = 0; k < kAngles; ++k) {
    const double likely = std::exp(logs[k] - most);
    sum += likely;
    near += likely * std::exp(-0.5 * std::pow(angle_of(k) / kByEye, 2));
    wrong_sign += std::exp(std::min(mirrored[k] - most, 700.0));
    const double found = earlier_sigma_ ? wrapped(angle_of(k) - earlier_yaw_) / *earlier_sigma_ : 0;
    logs[k] = likely * std::exp(-0.5 * found * found);
    total += logs[k];
    mean += std::polar(logs[k], angle_of(k));
  }
  yaw_ = std::arg(mean);
  for (std::size_t k = 0; k < kAngles; ++k)
    square += logs[k] * std::pow(wrapped(angle_of(k) - yaw_), 2);
  sigma_ = std::sqrt(square / total);
  // All priors have the integral 1 over the circle.
  const double otherwise = kOtherwise * sum / (2 * M_PI),
               reversed = kOtherwise * wrong_sign / (2 * M_PI),
               as_configured = (1 - kOtherwise) * near / (std::sqrt(2 * M_PI) * kByEye);
  turned_ = otherwise > kCertain * (otherwise + reversed + as_configured);
  const double odds = (otherwise + reversed) / as_configured;
  constexpr double kBefore = 2 * kOtherwise / (1 - kOtherwise);
  doubted_ = odds > (doubted_ ? kBefore : kDoubt);
  contradicted_ = odds > kOdds;
}

std::optional<Eigen::Matrix3d> MountingSearch::take_turn() {
  if (configured_ && !turned_) return std::nullopt;
  if (sigma_ > std::min(kKnown, 0.5 * taken_sigma_)) return std::nullopt;
  configured_ = false;
  taken_sigma_ = sigma_;
  const Vector2d by_slope = (by_imu_ - turned(by_wheel_, -yaw_)) / moving_;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw_, Vector3d::UnitZ()) *
                               levelled(Vector3d(by_slope.x(), by_slope.y(), kStandardGravity));
  product_ = turned(product_, -yaw_);
  mirrored_ = turned(mirrored_, yaw_);
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
