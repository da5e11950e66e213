// Unsigned path length of the antenna from the decay of trace similarity, in decorrelation lengths
// of the ground.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "gpr/filter/details_retention.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// Adds up how far the traces of a stream have moved away from each other, in decorrelation lengths.
//
// An anchor trace is compared with the newest one, both filtered, in gates along the trace (a gate
// is 1.25 periods of the band's centre). With the noise N subtracted,
//   q = (|y - y_anchor|^2 - N) / (|y - b|^2 + |y_anchor - b|^2 + 4 N),   b the mean over places,
// which is 1 - rho, and equals (distance / length)^2 while it is small. Changes of gain and time
// zero are no motion and are first projected out of the difference: they are its components along
// the mean of the two traces and along the first two derivatives of that mean. Because each gate is
// normalised, strong and weak reflectors have the same weight if they are above the noise. A step
// is the mean of sqrt(q). Once q exceeds `kStep`, which noise never does, the step is added to the
// path and the newest trace becomes the anchor. So a standing robot adds nothing.
//
// The largest q is that of traces far apart (near 1). It is measured on traces `kFar` anchors
// apart. A step close to it says nothing about its length.
//
// N is the smallest difference of neighbouring traces, averaged over a second; it rises slowly. It
// falls when a robot that started on the move stops for the first time. Steps that were too short
// by then are as long as they are from there on, which is another unit.
class DecorrelationPath {
 public:
  // gate: samples. unit: the last one in use.
  explicit DecorrelationPath(int gate, int unit = 0);

  // y: n samples, filtered. time: later than the last.
  void add(const float* y, int n, TimeNs time);

  double length() const { return length_; }
  int unit() const { return unit_; }
  int steps() const { return steps_; }                    // anchors passed
  int steps_too_long() const { return too_long_; }        // those with hardly any similarity left
  bool sees_ground() const { return usable_gates_ > 0; }  // some gate stands out of the noise
  // The next trace lies on other ground. What is known of noise and ground stays: noise that is
  // learnt anew while the antenna moves is too large, and makes every distance too short.
  void interrupt() { interrupted_ = true; }

 private:
  struct Similarity {
    double q = 0.0;     // mean over the usable gates
    double step = 0.0;  // mean of sqrt(q), likewise
  };

  void prepare(int n);  // shorter traces: what is known of the gates that are left stays
  void difference(const Eigen::VectorXf& a, const Eigen::VectorXf& b);  // -> change_
  Similarity compare(const Eigen::VectorXf& before);  // of `trace_`, after difference()
  void learn_unlike();
  void follow_noise(TimeNs time);
  void follow_unit();
  void move_anchor();

  int gate_, gates_ = 0;
  Eigen::VectorXf trace_, previous_, anchor_, older_, background_, mean_, slope_, curve_, delta_;
  Eigen::ArrayXf change_;          // per gate, |difference|^2, gain and time zero out
  Eigen::ArrayXf energy_, level_;  // per gate: of the pair; usual
  Eigen::ArrayXf noise_, block_;   // per gate: of change_; sum over the second under way
  Eigen::ArrayXf largest_noise_;   // per gate: since the unit began
  int block_traces_ = 0, places_ = 0;
  TimeNs block_start_ = 0;
  bool knows_noise_ = false, interrupted_ = false;
  int usable_gates_ = 0, steps_ = 0, too_long_ = 0, unit_ = 0;
  double base_ = 0.0, length_ = 0.0;
  double unlike_ = 1.0;  // q of traces that are far apart
  int unlike_seen_ = 0;
};

// The front end: gives the path length of each span of time.
class CoherenceFrontEnd : public FrontEnd {
 public:
  explicit CoherenceFrontEnd(const GprConfig& config);

  void add_trace(const GprTrace& trace) override;

  // At each tick that ends a span, returns one PathLength over it, unless nothing moved. It is
  // valid if the antenna moved during the whole span, slowly enough that neighbouring traces are
  // similar. `score` is the evenness of the motion: 0 if it rested for a third of the span, 1 at
  // constant speed.
  std::vector<Finding> tick(TimeNs tick) override;
  void reset() override;

 private:
  struct Place {
    TimeNs time;
    double length;
    int steps, too_long, unit;
  };
  Place at(TimeNs time) const;

  DetailsRetention filter_;
  double centre_hz_;
  double sample_interval_ = 0.0;
  DecorrelationPath path_;
  std::deque<Place> places_;  // after each trace, of the last span
  TimeNs from_ = 0;           // begin of the current span; 0: none
};

}  // namespace gprodom::gpr
