#include "motion/slip/slip_share.h"

#include <algorithm>

namespace gprodom::slip {

namespace {

constexpr double kPriorCounts_s = 30.0;  // one slip and a half (SlipModel::lasts_s)
// Beyond these no wheel is believed: one that never slipped may, and one that always does is no
// wheel to drive by.
constexpr double kLeastShare = 0.05, kMostShare = 0.6;

}  // namespace

SlipShare::SlipShare(double prior) : prior_(std::min(prior, kMostShare)) {}

void SlipShare::add(double seconds, double slips, double seen) {
  counts_.rolled_s += seconds * seen;
  counts_.slipped_s += seconds * slips * seen;
}

double SlipShare::value() const {
  return std::clamp(
      (prior_ * kPriorCounts_s + counts_.slipped_s) / (kPriorCounts_s + counts_.rolled_s),
      kLeastShare, kMostShare);
}

void SlipShare::take_up(Counts earlier) {
  const double kept = std::min(1.0, kEarlierCounts_s / std::max(earlier.rolled_s, 1e-9));
  counts_.rolled_s += kept * earlier.rolled_s;
  counts_.slipped_s += kept * earlier.slipped_s;
}

}  // namespace gprodom::slip
