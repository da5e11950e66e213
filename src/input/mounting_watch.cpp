#include "input/mounting_watch.h"

#include <Eigen/Geometry>
#include <cmath>

#include "base/text.h"

namespace gprodom {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kWindows = 8;               // of a block, and one before and after them
constexpr std::size_t kFewest = 10, kMost = 120;  // blocks
constexpr double kDriven_m = 0.25;                // in a block that is counted
constexpr double kDegree = M_PI / 180;
constexpr double kFallen = 45 * kDegree;  // no robot drives on such a slope
constexpr double kTold = 12 * kDegree;    // least error that is reported
constexpr double kOver = 0.7;             // of it: below, the report ends
constexpr double kSure = 5.0;             // standard deviations
constexpr double kAxisSure = 3.0;         // likewise, if gravity shows the same

std::string tell(const char* what, double angle) {
  return formatted(what, std::abs(angle) / kDegree) +
         ": set imu.rpy_body_imu (gprodom calibrate mount finds it)";
}

// Few blocks show their own scatter badly. The quantile of Student's t that is as rare as kSure of
// a normal error, over kSure (expansion of Cornish and Fisher).
double widening(double degrees_of_freedom) {
  constexpr double z = kSure;
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
  return widening(n - 1) * std::sqrt(sum * n / (n - 1));
}

}  // namespace

bool MountingWatch::Angle::beyond(double limit, double sigmas) const {
  return std::abs(value) > limit && std::abs(value) > sigmas * sigma;
}

void MountingWatch::add(const std::vector<MotionStep>& steps, std::optional<double> wheel_m,
                        const Vector3d& gyro_bias) {
  if (!windows_.add(steps, wheel_m, gyro_bias) || windows_.complete().size() < kWindows + 2) return;
  close_block();
  windows_.forget_oldest(kWindows);
  trouble_ = judge();
}

void MountingWatch::close_block() {
  const std::vector<MountingWindow>& windows = windows_.complete();
  Block block;
  Vector3d force = Vector3d::Zero();
  std::vector<Vector2d> by_wheel, by_imu;  // horizontal accelerations
  double driven = 0.0;
  bool wheel = true;
  for (std::size_t i = 1; i <= kWindows; ++i) {
    const MountingWindow &before = windows[i - 1], &now = windows[i], &after = windows[i + 1];
    const MountingAccelerations found = accelerations(before, now, after);
    by_wheel.push_back(found.by_wheel);
    by_imu.push_back(found.by_imu);
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
    block.across += a.x() * b.y() - a.y() * b.x();
    block.along += a.dot(b);
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

std::string MountingWatch::judge() const {
  const double limit = trouble_.empty() ? kTold : kOver * kTold;
  if (gravity_off_ > kFallen)
    return tell("gravity is %.0f degrees off the robot's up axis", gravity_off_);
  if (blocks_.size() < kFewest) return {};
  Vector2d leaning = Vector2d::Zero();
  for (const Block& block : blocks_) leaning += block.leaning;
  leaning /= static_cast<double>(blocks_.size());
  // A slope tilts gravity, but not the axis of the robot's turns.
  const double lean = std::atan(leaning.norm());
  const Angle axis = axis_along(leaning.normalized());
  if (lean > limit && axis.value > 0.5 * lean && axis.beyond(0.0, kAxisSure))
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
