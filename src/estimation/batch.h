// Batch solution over all states of a run (Ceres). It gives the `smoothed` figures, and is the
// reference for tests of the fixed-lag smoother.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "estimation/factors.h"
#include "estimation/marginal_prior.h"
#include "estimation/nav_state.h"

namespace gprodom {

class Batch {
 public:
  // `prior` holds the first state.
  Batch(const NavState& first, MarginalPrior prior);

  // Starting values; states are numbered from 0.
  void add_state(const NavState& estimate) { states_.push_back(estimate); }
  void set_state(size_t i, const NavState& estimate) { states_.at(i) = estimate; }
  void add_factor(size_t a, size_t b, std::shared_ptr<const Factor> factor);

  // A position from outside, between the states a and b. Of its error's variance the share `white`
  // is white; the rest is a Gauss-Markov process that goes on from that of an earlier fix, `kept`
  // being their correlation (docs/anchors.md).
  struct Fix {
    size_t a, b;
    FixFactor place;  // by the whole variance
    double white = 1.0;
    std::optional<size_t> before = {};
    double kept = 0.0;
    size_t antenna = 0;  // its number
  };
  // What is not known of an antenna of fixes, standard deviations: x and y of its place on the
  // robot (m), and how late its positions come (s). One of them 0: both are known.
  struct Antenna {
    double place_sigma = 0.0, delay_sigma = 0.0;
  };
  // By their numbers, before their fixes are added. At first there is one that is known.
  void set_antennas(std::vector<Antenna> antennas) { antennas_ = std::move(antennas); }
  // Its number, from 0.
  size_t add_fix(Fix fix);

  // What the wheel has counted over the states from a to b: rolled_way.h.
  struct Way {
    size_t a, b;
    Eigen::Vector3d contact;  // m, in body
    double counted_m, sigma_m;
  };
  void add_way(Way way);

  // Accelerations do not show the wheel's scale: it is held at this value.
  void hold_scale(double scale) { held_scale_ = scale; }
  // Revisits or fixes measure it.
  void free_scale() { held_scale_.reset(); }

  // Position (x, y) and heading of the first state are no longer held: fixes measure them.
  void free_place() { prior_.free_place(); }

  // The wheel's scale is a random walk of this standard deviation, 1/sqrt(s), above 0.
  void set_scale_walk(double sigma);

  // Multiplies the wheel's distance between the states a and a + 1 by e^l, with l = slips[a] where
  // there is one.
  void set_slips(const std::vector<std::optional<double>>& slips);

  struct Options {
    bool robust = true;  // false: every row quadratic
    int max_iterations = 50;
  };
  // antennas: what is found of each, as FixFactor has it. Throws std::runtime_error if Ceres finds
  // no usable solution.
  std::vector<NavState> solve(const Options& options,
                              std::vector<Eigen::Vector3d>* antennas = nullptr) const;

  const std::vector<NavState>& states() const { return states_; }
  size_t size() const { return states_.size(); }

 private:
  struct Link {
    size_t a, b;
    std::shared_ptr<const Factor> factor;
  };
  MarginalPrior prior_;
  std::optional<double> held_scale_;
  std::vector<NavState> states_;
  std::vector<Link> links_;
  std::vector<Fix> fixes_;
  std::vector<Antenna> antennas_{Antenna()};
  std::vector<Way> ways_;
};

}  // namespace gprodom
