// How far wheel and IMU differ on this robot while nothing slips, against what their noise
// explains.
//
// Errors of an acceleration in motion (tilt of body and ground, aliased vibration, mounting) have
// heavier tails than normal ones, and how heavy depends on the robot. On a small robot that rocks,
// five standard deviations of a normal error occur every minute. So a threshold in standard
// deviations is turned into the one that this robot's errors exceed as seldom.
// docs/estimation.md, "How much evidence a slip needs".
#pragma once

#include <deque>
#include <vector>

namespace gprodom {

class ErrorTail {
 public:
  ErrorTail();

  // Takes (difference / its standard deviation)^2 of one interval. Intervals must not overlap, and
  // a slip is to be counted once, since what follows its onset is not independent of it.
  void add(double square);

  // Standard deviations that the robot's errors exceed as seldom as a normal error exceeds
  // `deviations`; never less than that.
  double threshold(double deviations) const;

 private:
  void fit();

  std::deque<double> kept_;     // squares, oldest first
  std::vector<double> sorted_;  // the same, and what is assumed before
  // An error is size_ |z|^exponent_ standard deviations, z standard normal.
  double size_ = 1.0, exponent_ = 1.0;
};

}  // namespace gprodom
