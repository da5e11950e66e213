// How much larger the variance of a match is than the one which noise explains: the ground under
// two antennas differs a little, too. Learnt from matches in a row.
#pragma once

#include <array>
#include <deque>

namespace gprodom::gpr {

class MatchScatter {
 public:
  // A match in a row with the last one: its offset along the path of a wheel (m), and the variance
  // that noise explains (m^2).
  void add(double offset_m, double variance_m2);
  // The next match does not follow the last one.
  void interrupt() { last_ = {}; }

  // The true variance over that of noise.
  double excess() const;

 private:
  struct Offset {
    double offset_m = 0.0, variance_m2 = 0.0;
  };
  std::array<Offset, 3> last_;
  std::deque<double> scatter_;  // squares of their bends over those expected
};

}  // namespace gprodom::gpr
