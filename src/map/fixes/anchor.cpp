#include "map/fixes/anchor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kPathErrorLasts = 10.0;  // s, as long as a bend does
// Errors of code solutions last for minutes, by the atmosphere and by multipath of a robot that is
// slow. White is a share of the variance; of fixed ambiguities half of it is the receiver's noise.
constexpr double kCodeErrorLasts = 100.0, kWhiteOfCode = 0.05, kWhiteOfFixed = 0.5;
constexpr double kGate = 4.0;          // standard deviations of a difference that no error explains
constexpr double kLeastSigma = 0.005;  // m; of a fix: nobody knows a place on a robot better

// From the antenna at a to that at b, in the body's axes at a, with its covariance.
struct Way {
  Vector2d v;
  double yaw = 0.0;
  Matrix2d covariance;
};

Vector2d antenna_velocity(const Anchor& anchor) {
  const Vector2d arm = anchor.lever_arm.head<2>();
  return anchor.mark.velocity() + anchor.mark.yaw_rate() * Vector2d(-arm.y(), arm.x());
}

// Of the antenna's place on the robot and of its delay, which the two fixes have in common where
// they are of one antenna. R: from the body's axes at b to those at a.
Matrix2d unknown_covariance(const Anchor& a, const Anchor& b, const Matrix2d& R) {
  const auto square = [](const auto& by, double sigma) -> Matrix2d {
    return sigma * sigma * by * by.transpose();
  };
  const Vector2d at_a = antenna_velocity(a), at_b = R * antenna_velocity(b);
  if (a.antenna == b.antenna)
    return square((R - Matrix2d::Identity()).eval(), a.arm_sigma) +
           square((at_b - at_a).eval(), kDelaySigma);
  return square(Matrix2d::Identity().eval(), std::hypot(a.arm_sigma, b.arm_sigma)) +
         square(at_a, kDelaySigma) + square(at_b, kDelaySigma);
}

Way way_between(const Anchor& a, const Anchor& b, const ScaleKnown& scale) {
  const PlanarStep step = MapPath::way(a.mark, b.mark);
  const Eigen::Vector3d by_scale = step.d_scale * (scale.scale - step.scale);
  Way way;
  way.yaw = step.measured.yaw + by_scale[2];
  const Vector2d moved = step.measured.p + by_scale.head<2>();
  const Vector2d lever = Eigen::Rotation2Dd(way.yaw) * b.lever_arm.head<2>();
  way.v = moved + lever - a.lever_arm.head<2>();
  // Slips come and go: those of a long way are many, and partly cancel.
  const double slips = std::max(1.0, step.seconds / (2 * SlipModel{}.lasts_s));
  const Vector2d slipped = step.slip_sigma / std::sqrt(slips) * moved;
  const Vector2d scaled = scale.sigma * step.d_scale.head<2>();
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(way.yaw).toRotationMatrix();
  way.covariance = step.covariance.topLeftCorner<2, 2>() + slipped * slipped.transpose() +
                   scaled * scaled.transpose() + unknown_covariance(a, b, R);
  return way;
}

// Of the difference of two fixes.
Matrix2d difference_covariance(const Anchor& a, const Anchor& b) {
  const FixError of_a = fix_error(a), of_b = fix_error(b);
  const double kept = kept_between(a, b);
  return of_a.covariance + of_b.covariance -
         kept * std::sqrt((1 - of_a.white) * (1 - of_b.white)) *
             (of_a.covariance + of_b.covariance);
}

double along(const Matrix2d& covariance, const Vector2d& v) {
  const double square = v.squaredNorm();
  return square > 0.0 ? v.dot(covariance * v) / square : 0.5 * covariance.trace();
}

}  // namespace

FixError fix_error(const Anchor& anchor) {
  FixError error;
  error.covariance =
      anchor.covariance.topLeftCorner<2, 2>() + kLeastSigma * kLeastSigma * Matrix2d::Identity();
  if (anchor.quality == FixQuality::kSurveyed) return error;
  const bool fixed = anchor.quality == FixQuality::kFixed;
  const double own = 0.5 * error.covariance.trace();
  error.covariance += kPathError * kPathError * Matrix2d::Identity();
  error.white = (fixed ? kWhiteOfFixed : kWhiteOfCode) * own / (own + kPathError * kPathError);
  error.lasts_s = fixed ? kPathErrorLasts : kCodeErrorLasts;
  return error;
}

double kept_between(const Anchor& a, const Anchor& b) {
  if (a.antenna != b.antenna || a.quality != b.quality) return 0.0;
  const double lasts = fix_error(a).lasts_s;
  const double seconds = std::abs(to_seconds(b.mark.time() - a.mark.time()));
  return lasts > 0.0 ? std::exp(-std::max(seconds, 1e-3) / lasts) : 0.0;
}

bool agree(const Anchor& a, const Anchor& b, const ScaleKnown& scale) {
  const Way way = way_between(a, b, scale);
  const Vector2d seen = (b.p - a.p).head<2>();
  const double variance = along(way.covariance, way.v) + along(difference_covariance(a, b), seen);
  return std::abs(seen.norm() - way.v.norm()) <= kGate * std::sqrt(variance);
}

// a and b tell how the track lies: by that, and by the odometry since b, c is predicted.
bool agree(const Anchor& a, const Anchor& b, const Anchor& c, const ScaleKnown& scale) {
  const Way to_b = way_between(a, b, scale), on = way_between(b, c, scale);
  const Vector2d base = (b.p - a.p).head<2>();
  const double length = to_b.v.norm();
  const Matrix2d of_base = difference_covariance(a, b);
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
  const Matrix2d covariance = R * on.covariance * R.transpose() + difference_covariance(b, c) +
                              variance / (length * length) * turned * turned.transpose();
  return error.dot(covariance.inverse() * error) <= kGate * kGate;
}

}  // namespace gprodom
