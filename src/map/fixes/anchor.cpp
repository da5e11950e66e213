#include "map/fixes/anchor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kGate = 4.0;          // standard deviations of a difference that no error explains
constexpr double kSlipLasts = 20.0;    // s, as slip_model.h has it
constexpr double kLeastSigma = 0.005;  // m; of a fix: nobody knows a place on a robot better
// Share of the variance of a code solution that changes from fix to fix.
constexpr double kWhite = 0.05;

// From the antenna at a to that at b, in the body's axes at a, with its covariance.
struct Way {
  Vector2d v;
  double yaw = 0.0;
  Matrix2d covariance;
};

Way way_between(const Anchor& a, const Anchor& b, const ScaleKnown& scale) {
  const PlanarStep step = MapPath::way(a.mark, b.mark);
  const Eigen::Vector3d by_scale = step.d_scale * (scale.scale - step.scale);
  Way way;
  way.yaw = step.measured.yaw + by_scale[2];
  const Vector2d moved = step.measured.p + by_scale.head<2>();
  const Vector2d lever = Eigen::Rotation2Dd(way.yaw) * b.lever_arm.head<2>();
  way.v = moved + lever - a.lever_arm.head<2>();
  // Slips come and go: those of a long way are many, and partly cancel.
  const double slips = std::max(1.0, step.seconds / (2 * kSlipLasts));
  const Vector2d slipped = step.slip_sigma / std::sqrt(slips) * moved;
  const Vector2d scaled = scale.sigma * step.d_scale.head<2>();
  way.covariance = step.covariance.topLeftCorner<2, 2>() + slipped * slipped.transpose() +
                   scaled * scaled.transpose();
  return way;
}

// Of the difference of two fixes.
Matrix2d fix_covariance(const Anchor& a, const Anchor& b) {
  const Matrix2d of_a = a.covariance.topLeftCorner<2, 2>(),
                 of_b = b.covariance.topLeftCorner<2, 2>();
  Matrix2d sum = of_a + of_b;
  const double lasts = std::min(error_lasts(a.quality), error_lasts(b.quality));
  if (a.antenna == b.antenna && a.quality == b.quality && a.quality <= FixQuality::kFloat) {
    const double seconds = to_seconds(b.mark.time() - a.mark.time());
    sum *= 1 - (1 - kWhite) * std::exp(-seconds / lasts);
  }
  return sum + 2 * kLeastSigma * kLeastSigma * Matrix2d::Identity();
}

double along(const Matrix2d& covariance, const Vector2d& v) {
  const double square = v.squaredNorm();
  return square > 0.0 ? v.dot(covariance * v) / square : 0.5 * covariance.trace();
}

}  // namespace

double error_lasts(FixQuality quality) {
  switch (quality) {
    case FixQuality::kSurveyed:
      return 0.0;
    case FixQuality::kFixed:
      return 10.0;
    default:
      return 100.0;
  }
}

double own_share(FixQuality quality, double seconds) {
  const double lasts = error_lasts(quality);
  if (lasts <= 0.0) return 1.0;
  const double kept = std::exp(-std::max(seconds, 1e-3) / lasts);
  return (1 - kept) / (1 + kept);
}

bool agree(const Anchor& a, const Anchor& b, const ScaleKnown& scale) {
  const Way way = way_between(a, b, scale);
  const Vector2d seen = (b.p - a.p).head<2>();
  const double variance = along(way.covariance, way.v) + along(fix_covariance(a, b), seen);
  return std::abs(seen.norm() - way.v.norm()) <= kGate * std::sqrt(variance);
}

// a and b tell how the track lies: by that, and by the odometry since b, c is predicted.
bool agree(const Anchor& a, const Anchor& b, const Anchor& c, const ScaleKnown& scale) {
  const Way to_b = way_between(a, b, scale), on = way_between(b, c, scale);
  const Vector2d base = (b.p - a.p).head<2>();
  const double length = to_b.v.norm();
  const Matrix2d of_base = fix_covariance(a, b);
  const Vector2d aside(-base.y(), base.x());
  const Vector2d aside_of_way(-to_b.v.y(), to_b.v.x());
  const double variance = along(of_base, aside) + along(to_b.covariance, aside_of_way);
  constexpr double kStraightEnough = 0.2;  // rad; of a baseline that tells a direction
  if (!(length * kStraightEnough > std::sqrt(variance))) return true;
  const double turn = std::atan2(base.y(), base.x()) - std::atan2(to_b.v.y(), to_b.v.x());
  // In site, from the axes of the body at a, and at b.
  const Eigen::Rotation2Dd at_b(turn + to_b.yaw);
  const Vector2d ahead = at_b * on.v;
  const Vector2d error = (c.p - b.p).head<2>() - ahead;
  const Matrix2d R = at_b.toRotationMatrix();
  const Vector2d turned(-ahead.y(), ahead.x());
  const Matrix2d covariance = R * on.covariance * R.transpose() + fix_covariance(b, c) +
                              variance / (length * length) * turned * turned.transpose();
  return error.dot(covariance.inverse() * error) <= kGate * kGate;
}

}  // namespace gprodom
