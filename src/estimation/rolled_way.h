// The way that a wheel rolls through states in a row, and what its encoder's count over a gap of
// its messages tells of it. docs/estimation.md, "Gaps of the wheel".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "estimation/nav_state.h"
#include "gprodom/types.h"

namespace gprodom {

// Signed, as the encoder reports it.
struct RolledWay {
  double reported_m = 0.0;
  std::vector<StateVector> d;  // derivative by the error of each state
};

// contact: of the wheel with the ground, m, in body.
RolledWay rolled_way(const NavState* states, std::size_t count, const Eigen::Vector3d& contact);

// The same as estimated; its variance (m^2), and its covariance with the newest state's error.
struct EstimatedWay {
  double reported_m = 0.0, variance = 0.0;
  StateVector with_newest = StateVector::Zero();
};

// What the encoder tells after a gap; signed, as reported.
struct CountedWay {
  TimeNs from = 0, to = 0;   // the gap, of state times
  double counted_m = 0.0;    // over it, if the encoder has counted on
  double restarted_m = 0.0;  // likewise, if it has begun at 0 in the gap: its count
  double slips = 0.0;        // probability that the wheel slipped meanwhile, and then the standard
  double slip_sigma = 0.0;   // deviation of its ln(true distance / distance by the wheel)
};

// The inverse variance of the difference between count and estimate, 1/m^2: mean and standard
// deviation over the hypotheses that the wheel has not slipped, that it has, and that the encoder
// has not counted on, which it is 0 for.
struct CountWeight {
  double mean = 0.0, sigma = 0.0;
};
// variance: m^2, of the encoder.
CountWeight weight_of(const EstimatedWay& way, const CountedWay& told, double variance);

}  // namespace gprodom
