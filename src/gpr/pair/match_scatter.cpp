#include "gpr/pair/match_scatter.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "base/median.h"

namespace gprodom::gpr {

namespace {

// Learnt from so many matches. It begins with that of ground that was never seen, which counts as a
// few of them.
constexpr double kFirstExcess = 4.0;
constexpr std::size_t kMatches = 30, kFirstWeight = 5;

}  // namespace

// A wheel's path is wrong by a factor that hardly changes over three matches, so what scatters are
// the matches.
void MatchScatter::add(double offset_m, double variance_m2) {
  last_[0] = last_[1];
  last_[1] = last_[2];
  last_[2] = {offset_m, variance_m2};
  if (last_[0].variance_m2 <= 0) return;
  const double bend = last_[1].offset_m - 0.5 * (last_[0].offset_m + last_[2].offset_m);
  const double expected =
      last_[1].variance_m2 + 0.25 * (last_[0].variance_m2 + last_[2].variance_m2);
  scatter_.push_back(bend * bend / expected);
  if (scatter_.size() > kMatches) scatter_.pop_front();
}

// By the median, since a slip that begins bends the path, too.
double MatchScatter::excess() const {
  constexpr double kMedianOfSquares = 0.455;  // of a normal distribution
  std::vector<double> all(scatter_.begin(), scatter_.end());
  all.resize(all.size() + kFirstWeight, kFirstExcess * kMedianOfSquares);
  return median(std::move(all)) / kMedianOfSquares;
}

}  // namespace gprodom::gpr
