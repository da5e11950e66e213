#include "estimation/rolled_way.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimation/factors.h"
#include "estimation/kernels/so3.h"

namespace gprodom {
namespace {

constexpr double kMostTurn = 1.0;     // rad, in an interval; beyond, the robot spins on the spot
constexpr double kBeginsAnew = 0.01;  // share of the gaps in which an encoder begins at 0

}  // namespace

RolledWay rolled_way(const NavState* states, std::size_t count, const Eigen::Vector3d& contact) {
  const DisplacementFactor forwards({}, contact);  // from 0 m, by 1 m
  RolledWay way;
  way.d.assign(count, StateVector::Zero());
  Residual chord;
  Jacobian Ja, Jb;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const NavState &a = states[i], &b = states[i + 1];
    forwards.evaluate(a, b, chord, &Ja, &Jb);
    // In a bend by the angle t the chord's part along the first heading is sin(t) / t of the arc.
    const double turn = so3::log(a.q_odom_body.conjugate() * b.q_odom_body).z();
    const double t = std::clamp(turn, -kMostTurn, kMostTurn);
    const double arc = std::abs(t) < 1e-3 ? 1.0 : t / std::sin(t);
    const double per_chord = a.wheel_scale * arc;
    way.reported_m += per_chord * chord[0];
    way.d[i] += per_chord * Ja.transpose();
    way.d[i][row::kScale] += arc * chord[0];
    way.d[i + 1] += per_chord * Jb.transpose();
  }
  return way;
}

CountWeight weight_of(const EstimatedWay& way, const CountedWay& told, double variance) {
  if (told.counted_m == 0.0) return {};  // it may have been off
  const double off = told.counted_m - way.reported_m;
  // Student's, with 4 degrees of freedom: the sizes of the IMU's errors are estimates.
  const auto density = [off](double of) {
    return 3.0 / 8.0 * std::pow(1 + off * off / (4 * of), -2.5) / std::sqrt(of);
  };
  struct Hypothesis {
    double likelihood, weight;
  };
  std::array<Hypothesis, 3> all{};

  // It has counted on, without slip or with one.
  const double without = way.variance + variance;
  const double with = without + std::pow(told.slip_sigma * told.counted_m, 2);
  all[0] = {(1 - kBeginsAnew) * (1 - told.slips) * density(without), 1 / without};
  all[1] = {(1 - kBeginsAnew) * told.slips * density(with), 1 / with};

  // It has begun at 0 somewhere on the way.
  const double most = std::abs(way.reported_m) + 2 * std::sqrt(way.variance);
  if (std::abs(told.restarted_m) <= most) all[2].likelihood = kBeginsAnew / (2 * most);

  double sum = 0.0, square = 0.0, total = 0.0;
  for (const Hypothesis& one : all) total += one.likelihood;
  for (const Hypothesis& one : all) {
    const double share = one.likelihood / total;
    sum += share * one.weight;
    square += share * one.weight * one.weight;
  }
  return {sum, std::sqrt(std::max(0.0, square - sum * sum))};
}

}  // namespace gprodom
