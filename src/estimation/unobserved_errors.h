// Errors that no sensor shows, and that the window leaves out: the uncertainty of a wheel's scale
// that is held (Schmidt's "consider"), and errors of the path that last. docs/estimation.md.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "estimation/drive_traits.h"
#include "estimation/long_gap.h"
#include "estimation/state_input.h"
#include "gprodom/config.h"

namespace gprodom {

// Whether accelerations may show the wheel's scale, or it stays at its first value: "A scale that
// is held".
class HeldScale {
 public:
  HeldScale(const WheelConfig& config, const InitialState& initial);

  bool is_held() const { return held_; }
  bool is_estimated() const { return may_be_shown_ && !held_; }
  double first() const { return first_; }

  // Before the next interval. newest: with its covariance at the last solve. Returns the state with
  // which the window has to begin anew, if the scale is held from now on, or no longer.
  std::optional<CarriedState> decide(const StateInput& input, const CarriedState& newest);

  // By the scale's error while it is held, of the newest state.
  StateMatrix covariance(const NavState& newest) const;

 private:
  bool not_shown(const StateInput& input, const CarriedState& newest);
  CarriedState with_first(CarriedState now) const;
  CarriedState held(CarriedState now);
  CarriedState released(CarriedState now);
  StateMatrix covariance_of_first(const NavState& newest) const;

  bool may_be_shown_;  // wheel.scale_sigma
  bool held_, held_without_axes_ = false, known_late_ = false;
  double first_, first_sigma_;
  Eigen::Vector3d start_;  // in odom
  double driven_s_ = 0.0;  // with a usable wheel, in the trial of the scale
};

// Errors of the path that go on for longer than an interval.
// - In a bend a wheel that is late by a time tau adds each distance with a heading that has turned
//   on by tau times the turn rate.
// - Side slip keeps its size over a bend. Its variance in the wheel's factor is that of intervals
//   that are independent, which leads to a sum that is too small.
class LastingErrors {
 public:
  explicit LastingErrors(const WheelConfig& config) : drive_(drive_traits(config)) {}

  // The interval from one state to the next.
  void add(const StateInput& input, const NavState& before, const NavState& newest);

  // Of the position: these, and the distance that the wheel has not reported yet.
  StateMatrix covariance(const NavState& newest) const;

 private:
  DriveTraits drive_;
  // Change of the path's end (m/s, in odom) by a delay of the wheel, which is not compensated.
  Eigen::Vector3d turned_by_delay_ = Eigen::Vector3d::Zero();
  double wheel_delay_s_ = 0.0;
  Eigen::Matrix3d side_slip_covariance_ = Eigen::Matrix3d::Zero();  // m^2, of the path's end
};

}  // namespace gprodom
