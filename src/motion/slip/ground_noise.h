// How much the decorrelation length of a ground varies along the path, learnt while driving.
#pragma once

#include <deque>

namespace gprodom::slip {

// x = ln(metres / lengths) of a span has two errors: one of its own, and one of the place, whose
// correlation falls to 1/e over kPlace. Differences of two spans show both: those of neighbours
// mostly the first, those of spans 2 m apart the second as well. The medians of their squares are
// used, because a slip begins or ends within few of the pairs. A slip that lasts shifts the spans
// alike and cancels in the difference.
class GroundNoise {
 public:
  static constexpr double kPlace = 1.0;  // m

  // at_m: distance along the path.
  void add(double at_m, double log_metres_per_length);

  // Spans to come cannot be compared with those so far.
  void begin_unit() { spans_.clear(); }

  double span_sigma() const { return span_sigma_; }    // of the error of a single span
  double place_sigma() const { return place_sigma_; }  // of the error of a place (stationary)

 private:
  static constexpr std::size_t kMost = 200;  // spans kept
  struct Span {
    double at_m, x;
  };
  std::deque<Span> spans_;
  double span_sigma_ = 0.1, place_sigma_ = 0.12;  // priors
};

}  // namespace gprodom::slip
