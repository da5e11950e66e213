// How evenly a ground's decorrelation length lies along the way, learnt while driving.
#pragma once

#include <deque>

namespace gprodom::slip {

// ln(metres / lengths) of spans in a row scatters about its mean by what each span alone is off,
// and by what is of the place and fades along the way with kPlace. The variance of all is the sum
// of both; that of neighbours' differences is twice the first alone, nearly. From medians of
// squares: a slip that is taken for something else is not the ground's.
class GroundNoise {
 public:
  static constexpr double kPlace = 1.5;  // m

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
