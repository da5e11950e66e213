// How evenly a ground's decorrelation length lies along the way, learnt while driving.
#pragma once

#include <deque>

namespace gprodom::slip {

// ln(metres / lengths) of a span is off by an error of its own and by one of the place, which fades
// along the way with kPlace. Differences of two spans show both: those of neighbours mostly the
// former, those of spans 2 m apart the latter too. Medians of their squares are taken, since a slip
// begins or ends within few of the pairs: what is left of slip in the levels does not matter.
class GroundNoise {
 public:
  static constexpr double kPlace = 1.0;  // m

  // at: m along the way.
  void add(double at_m, double log_metres_per_length);

  double span_sigma() const { return span_sigma_; }    // of a span's x, alone
  double place_sigma() const { return place_sigma_; }  // of the place, stationary

 private:
  static constexpr std::size_t kMost = 200;  // spans kept
  struct Span {
    double at_m, x;
  };
  std::deque<Span> spans_;
  double span_sigma_ = 0.1, place_sigma_ = 0.12;  // before anything is known
};

}  // namespace gprodom::slip
