// Distances between states of the window, by the radar, and by the wheel over a gap of its
// messages: StateEstimator's part of them.
#include <algorithm>
#include <cmath>
#include <memory>

#include "estimation/kernels/so3.h"
#include "estimation/revised_state.h"
#include "estimation/state_estimator.h"

namespace gprodom {

using Eigen::Vector3d;

namespace {

// Standard deviations at which a displacement of the radar loses weight: most of the errors that
// its sigma covers keep theirs, and a wrong match has little.
constexpr double kDisplacementRobustThreshold = 2.5;

// rad, between the passages of two antennas over a place. Beyond, the robot turns on the spot, and
// the antennas do not pass the same place.
constexpr double kMostTurnOfPassage = 0.5;
// m, of an antenna beside the line through the other one, as mounted by tape.
constexpr double kAntennasAside = 0.02;

}  // namespace

// The states nearest to both ends; velocities cover the remaining time. Nothing if an end lies
// outside the window.
std::optional<StateEstimator::Span> StateEstimator::span(TimeNs from, TimeNs to) const {
  const TimeNs half_interval = from_seconds(0.5 / config_.smoother.state_rate);
  auto nearest = [&](TimeNs time) {
    auto best = smoother_.oldest_id();
    for (auto id = best; id <= smoother_.newest_id(); ++id)
      if (std::abs(smoother_.state(id).time - time) < std::abs(smoother_.state(best).time - time))
        best = id;
    return best;
  };
  const auto a = nearest(from), b = nearest(to);
  const TimeNs offset_a = from - smoother_.state(a).time, offset_b = to - smoother_.state(b).time;
  if (std::abs(offset_a) > half_interval || std::abs(offset_b) > half_interval) return std::nullopt;
  return Span{a, b, to_seconds(offset_a), to_seconds(offset_b)};
}

bool StateEstimator::add_displacement(const PlacedDisplacement& d) {
  const auto between = d.valid ? span(d.from, d.to) : std::nullopt;
  if (!between) return false;
  DisplacementFactor::Measurement m;
  m.distance_m = d.distance_m;
  m.sigma_m = d.sigma_m;
  m.offset_a_s = between->offset_a_s;
  m.offset_b_s = between->offset_b_s;
  const bool is_unsigned =
      d.kind == DisplacementKind::kMotion || config_.gpr.fusion == Fusion::kNorm;
  m.form = is_unsigned ? DisplacementFactor::Form::kNorm : DisplacementFactor::Form::kSigned;
  m.robust_threshold = kDisplacementRobustThreshold;
  const Vector3d lever_arm = d.lever_arm.value_or(config_.gpr.lever_arm);
  return add_factor(between->a, between->b, std::make_shared<DisplacementFactor>(m, lever_arm));
}

// On a straight line the place is the same: 0 m between one antenna then and the other one now. In
// a bend by the angle t, that holds for antennas fixed to the body over the middle of the track. If
// they follow the track instead, as on a trailer, the body moves by their distance b, and 0 becomes
// b t^2 / 12. What a robot does lies in between.
bool StateEstimator::add_passage(const AntennaPassage& passage) {
  const auto between = span(passage.from, passage.to);
  if (!between) return false;
  const Vector3d turned = so3::log(smoother_.state(between->a).q_odom_body.conjugate() *
                                   smoother_.state(between->b).q_odom_body);
  const double turn = turned.z();
  if (std::abs(turn) > kMostTurnOfPassage) return false;
  const double range = passage.distance_m() * turn * turn / 12;
  DisplacementFactor::Measurement m;
  m.distance_m = 0.5 * range;
  m.sigma_m = std::sqrt(passage.sigma_m * passage.sigma_m + range * range / 12 +
                        std::pow(0.5 * turn * kAntennasAside, 2));
  m.offset_a_s = between->offset_a_s;
  m.offset_b_s = between->offset_b_s;
  m.robust_threshold = kDisplacementRobustThreshold;
  return add_factor(between->a, between->b,
                    std::make_shared<DisplacementFactor>(m, passage.lever_from, passage.lever_to));
}

// The window holds the gap of the wheel. A count ties all its states to each other, which a window
// of links between two states cannot hold. So it begins anew.
void StateEstimator::take_count(const StateInput& input) {
  const CountedWay& told = *input.counted;
  const auto between = span(told.from, told.to);
  if (!between || between->offset_a_s != 0 || between->offset_b_s != 0) return;
  const WheelConfig& c = config_.wheel;
  const Vector3d contact(c.lever_arm.x(), input.wheel_y_m, c.lever_arm.z());
  const EstimatedWay way = smoother_.way_between(between->a, between->b, contact);
  const double variance = c.noise * c.noise * std::abs(told.counted_m) +
                          std::pow(std::max(c.noise_floor, input.wheel_floor_m), 2);
  const CountWeight weight = weight_of(way, told, variance);
  if (weight.mean <= 0.0) return;
  if (batch_)
    batch_->add_way({static_cast<size_t>(between->a + id_offset_),
                     static_cast<size_t>(between->b + id_offset_), contact, told.counted_m,
                     std::sqrt(1 / weight.mean - way.variance)});
  continue_from(
      with_counted_way({smoother_.newest(), last_covariance_}, way, told.counted_m, weight));
}

std::vector<WayPoint> StateEstimator::way() const {
  std::vector<WayPoint> way;
  for (auto id = smoother_.oldest_id(); id <= smoother_.newest_id(); ++id) {
    const NavState& b = smoother_.state(id);
    double s = 0.0, heading = 0.0;
    if (!way.empty()) {
      const NavState& a = smoother_.state(id - 1);
      heading = way.back().heading_rad + so3::log(a.q_odom_body.conjugate() * b.q_odom_body).z();
      const Vector3d ahead =
          (a.q_odom_body * Vector3d::UnitX() + b.q_odom_body * Vector3d::UnitX());
      s = way.back().s_m + ahead.normalized().dot(b.p_odom - a.p_odom);
    }
    way.push_back({b.time, s, heading});
  }
  return way;
}

}  // namespace gprodom
