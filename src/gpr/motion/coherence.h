// How far the antenna has moved, in units that the ground sets: the decay of trace similarity.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "gpr/filter/details_retention.h"
#include "gprodom/config.h"
#include "gprodom/front_end.h"

namespace gprodom::gpr {

// The way a stream of traces has gone through the space of traces, in decorrelation lengths.
//
// Between an anchor trace and the newest one, filtered, gate by gate along the trace (a gate is
// 1.25 periods of the band's centre), with the noise N taken off:
//   q = (|y - y_anchor|^2 - N) / (|y - b|^2 + |y_anchor - b|^2 + 4 N),   b the mean over places,
// which is 1 - rho, (distance / length)^2 while that is small. What changes without motion is
// taken out of the difference first: the trace's gain and its time zero, that is, the components
// along the mean of the two traces and along its first two derivatives. Normalised gate by gate,
// strong reflectors and weak ones count alike as far as they stand out of the noise. A step is the
// mean of sqrt(q); once q passes `kStep`, which no noise does, it is added to the way and the
// newest trace becomes the anchor. So a robot that stands adds nothing.
//
// How large q becomes however far apart two traces are (1, but for what gain and time zero change)
// is seen on traces `kFar` anchors apart. A step with most of that says nothing of its length.
//
// N is the least that the difference of neighbouring traces has been over a second, rising slowly.
class DecorrelationPath {
 public:
  // gate: samples.
  explicit DecorrelationPath(int gate);

  // y: n samples, filtered. time: later than the last.
  void add(const float* y, int n, TimeNs time);

  double length() const { return length_; }
  int steps() const { return steps_; }                    // anchors passed
  int steps_too_long() const { return too_long_; }        // of them, hardly similar any more
  bool sees_ground() const { return usable_gates_ > 0; }  // some gate stands out of the noise
  void reset();

 private:
  struct Similarity {
    double q = 0.0;     // mean over the usable gates
    double step = 0.0;  // mean of sqrt(q), likewise
  };

  void prepare(int n);
  void difference(const Eigen::VectorXf& a, const Eigen::VectorXf& b);  // -> change_
  Similarity compare(const Eigen::VectorXf& before);  // of `trace_`, after difference()
  void learn_unlike();
  void follow_noise(TimeNs time);
  void move_anchor();

  int gate_, gates_ = 0;
  Eigen::VectorXf trace_, previous_, anchor_, older_, background_, mean_, slope_, curve_, delta_;
  Eigen::ArrayXf change_;          // per gate, |difference|^2, gain and time zero out
  Eigen::ArrayXf energy_, level_;  // per gate: of the pair; usual
  Eigen::ArrayXf noise_, block_;   // per gate: of change_; sum over the second under way
  int block_traces_ = 0, places_ = 0;
  TimeNs block_start_ = 0;
  bool knows_noise_ = false;
  int usable_gates_ = 0, steps_ = 0, too_long_ = 0;
  double base_ = 0.0, length_ = 0.0;
  double unlike_ = 1.0;  // q of traces that are far apart
  int unlike_seen_ = 0;
};

// Spans of the way as PathLength.
class CoherenceFrontEnd : public FrontEnd {
 public:
  explicit CoherenceFrontEnd(const GprConfig& config);

  void add_trace(const GprTrace& trace) override;

  // At every tick that closes a span one PathLength over that span, unless nothing moved. Valid
  // where the antenna moved all through it, at a speed at which neighbouring traces are still
  // alike. `score` is how evenly: 0 where it rested for a third of the span, 1 at constant speed.
  std::vector<Finding> tick(TimeNs tick) override;
  void reset() override;

 private:
  struct Place {
    TimeNs time;
    double length;
    int steps, too_long;
  };
  Place at(TimeNs time) const;

  TimeNs span_;
  DetailsRetention filter_;
  double centre_hz_;
  double sample_interval_ = 0.0;
  DecorrelationPath path_;
  std::deque<Place> places_;  // after each trace, of the last span
  TimeNs from_ = 0;           // where the span under way began; 0: none
};

}  // namespace gprodom::gpr
