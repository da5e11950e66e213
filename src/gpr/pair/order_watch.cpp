#include "gpr/pair/order_watch.h"

#include <algorithm>

namespace gprodom::gpr {

namespace {

// Of a patch: columns that are independent (Alongside: 6 cm apart, in 0.4 m). A model that leaves
// the share v of the variance in N complex samples has the likelihood v^-N, and evidence is -ln v.
// Frequencies and blocks of depth are counted as one, as they have the errors of the path in
// common.
constexpr double kIndependent = 7.0;

// The most that one patch may say: ground that repeats itself, or is like another place by chance,
// is not seen four times in a row.
constexpr double kMostOfPatch = 3.0;

// More likely than not by a factor of three, before a passage is used: swapped cables are rare.
constexpr double kConfirmed = -1.0;
// Odds of 10000 to 1: four patches at least.
constexpr double kSwapped = 9.2;

}  // namespace

void OrderWatch::compared(double as_configured, double swapped) {
  const double says = kIndependent * (swapped - as_configured);
  ratio_ += std::clamp(says, -kMostOfPatch, kMostOfPatch);
  // Old evidence does not keep a change from being seen: cables are exchanged.
  ratio_ = std::clamp(ratio_, -(kSwapped + kMostOfPatch), kSwapped + kMostOfPatch);
  if (ratio_ >= kSwapped) swapped_ = true;
  if (ratio_ <= kConfirmed) swapped_ = false;
}

bool OrderWatch::confirmed() const { return !swapped_ && ratio_ <= kConfirmed; }

}  // namespace gprodom::gpr
