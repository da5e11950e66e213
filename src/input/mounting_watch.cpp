#include "input/mounting_watch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace gprodom {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kWindow_s = 0.5;
constexpr std::size_t kWindows = 8;               // of a block, and one before and after them
constexpr std::size_t kFewest = 10, kMost = 120;  // blocks
constexpr double kDriven_m = 0.25;                // in a block that is counted
constexpr double kDegree = M_PI / 180;
constexpr double kFallen = 45 * kDegree;  // no robot drives on such a slope
constexpr double kTold = 12 * kDegree;    // least error that is reported
constexpr double kOver = 0.7;             // of it: below, the report ends
constexpr double kSure = 5.0;             // standard deviations
constexpr double kAxisSure = 3.0;         // likewise, if gravity shows the same
// A mounting that is not configured is used once its yaw is as good as this. The accelerations must
// be the wheel's to this correlation: those of a wheel that is late by half a swing are not.
constexpr double kUsable = 10 * kDegree, kCorrelated = 0.3;
// Errors of windows that follow each other are alike: as if there were so many fewer.
constexpr double kAlike = 2.0;
constexpr double kUsedSure = 3.0;  // standard deviations

std::string tell(const char* what, double angle) {
  char text[240];
  std::snprintf(text, sizeof text, what, std::abs(angle) / kDegree);
  return std::string(text) + ": set imu.rpy_body_imu (gprodom calibrate mount finds it)";
}

// Few blocks show their own scatter badly. The quantile of Student's t that is as rare as z of a
// normal error, over z (expansion of Cornish and Fisher).
double widening(double degrees_of_freedom, double z) {
  const double first = (z * z * z + z) / 4;
  const double second = (5 * std::pow(z, 5) + 16 * std::pow(z, 3) + 3 * z) / 96;
  return 1 + (first / degrees_of_freedom + second / std::pow(degrees_of_freedom, 2)) / z;
}

// Of a sum over blocks, each of which errs by its own.
template <typename Blocks, typename Error>
double deviation(const Blocks& blocks, Error error) {
  double sum = 0.0;
  for (const auto& block : blocks) sum += std::pow(error(block), 2);
  const auto n = static_cast<double>(blocks.size());
  return widening(n - 1, kSure) * std::sqrt(sum * n / (n - 1));
}

}  // namespace

bool MountingWatch::Angle::beyond(double limit, double sigmas) const {
  return std::abs(value) > limit && std::abs(value) > sigmas * sigma;
}

void MountingWatch::add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
                        const Vector3d& gyro_bias) {
  if (imu_silent(steps)) {
    open_ = {};
    windows_.clear();
    wheel_m_ = wheel_m;
    return;
  }
  for (const MotionStep& step : steps) {
    open_.seconds += step.dt;
    open_.force += step.acceleration * step.dt;
    open_.rate += (step.angular_velocity - gyro_bias) * step.dt;
  }
  if (open_.seconds >= kWindow_s) close_window(wheel_m);
}

void MountingWatch::close_window(std::optional<double> wheel_m) {
  open_.force /= open_.seconds;
  open_.rate /= open_.seconds;
  open_.wheel = wheel_m && wheel_m_;
  if (open_.wheel) open_.speed = (*wheel_m - *wheel_m_) / open_.seconds;
  windows_.push_back(open_);
  open_ = {};
  wheel_m_ = wheel_m;
  if (windows_.size() < kWindows + 2) return;
  close_block();
  windows_.erase(windows_.begin(), windows_.begin() + kWindows);
  trouble_ = judge();
}

void MountingWatch::close_block() {
  Block block;
  Vector3d force = Vector3d::Zero();
  std::vector<Vector2d> by_wheel, by_imu;  // horizontal accelerations
  double driven = 0.0;
  bool wheel = true;
  for (std::size_t i = 1; i <= kWindows; ++i) {
    const Window &before = windows_[i - 1], &now = windows_[i], &after = windows_[i + 1];
    const double apart = 0.5 * (before.seconds + after.seconds) + now.seconds;
    by_wheel.emplace_back((after.speed - before.speed) / apart, now.speed * now.rate.z());
    by_imu.emplace_back(now.force.head<2>());
    force += now.force / kWindows;
    block.turned += now.rate.head<2>() * now.rate.z();
    block.turned_up += now.rate.z() * now.rate.z();
    driven += std::abs(now.speed) * now.seconds;
    wheel = wheel && before.wheel && now.wheel && after.wheel;
  }
  gravity_off_ = std::atan2(force.head<2>().norm(), force.z());
  if (!wheel || driven < kDriven_m || gravity_off_ > kFallen) return;
  // Without their means, since a slope and a bias are constant over a block.
  Vector2d mean_by_wheel = Vector2d::Zero(), mean_by_imu = Vector2d::Zero();
  for (std::size_t i = 0; i < kWindows; ++i) {
    mean_by_wheel += by_wheel[i] / kWindows;
    mean_by_imu += by_imu[i] / kWindows;
  }
  for (std::size_t i = 0; i < kWindows; ++i) {
    const Vector2d a = by_wheel[i] - mean_by_wheel, b = by_imu[i] - mean_by_imu;
    const Vector2d swung(a.dot(b), a.x() * b.y() - a.y() * b.x());
    block.along += swung.x();
    block.across += swung.y();
    block.squares += swung * swung.transpose();
    block.by_wheel += a.squaredNorm();
    block.by_imu += b.squaredNorm();
  }
  block.leaning = (mean_by_imu - mean_by_wheel) / force.z();
  blocks_.push_back(block);
  if (blocks_.size() > kMost) blocks_.pop_front();
}

MountingWatch::Angle MountingWatch::turned_about_up() const {
  Vector2d sum = Vector2d::Zero();
  for (const Block& block : blocks_) sum += Vector2d(block.along, block.across);
  const double angle = std::atan2(sum.y(), sum.x()), c = std::cos(angle), s = std::sin(angle);
  const double error =
      deviation(blocks_, [&](const Block& block) { return c * block.across - s * block.along; });
  return {angle, error / sum.norm()};
}

// The tilt of the axis of the robot's turns in that direction.
MountingWatch::Angle MountingWatch::axis_along(const Vector2d& direction) const {
  double turned = 0.0, up = 0.0;
  for (const Block& block : blocks_) {
    turned += block.turned.dot(direction);
    up += block.turned_up;
  }
  const double slope = turned / up;
  const double error = deviation(blocks_, [&](const Block& block) {
    return block.turned.dot(direction) - slope * block.turned_up;
  });
  return {std::atan(slope), error / up};
}

// Of the robot's up axis, by gravity.
Vector2d MountingWatch::leaning() const {
  Vector2d sum = Vector2d::Zero();
  for (const Block& block : blocks_) sum += block.leaning;
  return sum / static_cast<double>(blocks_.size());
}

// The scatter of the windows tells the error before there are many blocks.
std::optional<MountingWatch::Turn> MountingWatch::turn() const {
  if (blocks_.empty()) return std::nullopt;
  Block sum;
  double of_blocks = 0.0;
  for (const Block& block : blocks_) {
    sum.along += block.along;
    sum.across += block.across;
    sum.by_wheel += block.by_wheel;
    sum.by_imu += block.by_imu;
    sum.squares += block.squares;
  }
  const Vector2d direction = Vector2d(sum.along, sum.across).normalized();
  const Vector2d normal(-direction.y(), direction.x());
  for (const Block& block : blocks_)
    of_blocks += std::pow(normal.dot(Vector2d(block.along, block.across)), 2);
  const double of_windows = kAlike * normal.dot(sum.squares * normal);
  const double independent = static_cast<double>(blocks_.size() * kWindows) / kAlike;
  const double size = std::hypot(sum.along, sum.across);
  Turn turn;
  turn.R =
      Eigen::AngleAxisd(-std::atan2(sum.across, sum.along), Vector3d::UnitZ()).toRotationMatrix();
  turn.yaw_sigma = widening(independent - 1, kUsedSure) *
                   std::sqrt(std::max(of_windows, of_blocks) * independent / (independent - 1)) /
                   size;
  turn.usable =
      turn.yaw_sigma < kUsable && size > kCorrelated * std::sqrt(sum.by_wheel * sum.by_imu);
  if (blocks_.size() < kFewest) return turn;
  // What leans by gravity alone may be a slope, and stays.
  const Vector2d lean = leaning();
  if (leans(lean)) {
    const Vector3d up(lean.x(), lean.y(), 1.0);
    turn.R *= Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()).toRotationMatrix();
  }
  return turn;
}

void MountingWatch::turned(const Eigen::Matrix3d& R) {
  for (Window& window : windows_) {
    window.force = R * window.force;
    window.rate = R * window.rate;
  }
  open_.force = R * open_.force;
  open_.rate = R * open_.rate;
  const Eigen::Matrix2d about_up =
      Eigen::Rotation2Dd(std::atan2(R(1, 0), R(0, 0))).toRotationMatrix();
  for (Block& block : blocks_) {
    const Vector2d swung = about_up * Vector2d(block.along, block.across);
    block.along = swung.x();
    block.across = swung.y();
    block.squares = about_up * block.squares * about_up.transpose();
    block.turned = (R * Vector3d(block.turned.x(), block.turned.y(), block.turned_up)).head<2>();
    const Vector3d up = R * Vector3d(block.leaning.x(), block.leaning.y(), 1.0);
    block.leaning = up.head<2>() / up.z();
  }
  trouble_ = {};
}

// Whether the axis of turns leans as gravity does, so that it is not a slope.
bool MountingWatch::leans(const Vector2d& lean) const {
  const Angle axis = axis_along(lean.normalized());
  return axis.value > 0.5 * std::atan(lean.norm()) && axis.beyond(0.0, kAxisSure);
}

std::string MountingWatch::judge() const {
  const double limit = trouble_.empty() ? kTold : kOver * kTold;
  if (gravity_off_ > kFallen)
    return tell("gravity is %.0f degrees off the robot's up axis", gravity_off_);
  if (blocks_.size() < kFewest) return {};
  // A slope tilts gravity, but not the axis of the robot's turns.
  const Vector2d direction = leaning();
  const double lean = std::atan(direction.norm());
  if (lean > limit && leans(direction))
    return tell("gravity and the axis of turns are %.0f degrees off the robot's up axis", lean);
  const Angle turned = turned_about_up();
  if (turned.beyond(limit, kSure))
    return tell(
        "accelerations are rotated by %.0f degrees about the up axis against wheel and "
        "gyro (or the wheel counts backwards)",
        turned.value);
  return {};
}

}  // namespace gprodom
