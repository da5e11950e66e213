#include "motion/slip/slip_hypothesis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gprodom::slip {
namespace {

struct Sums {
  double slips = 0.0;             // probability
  double mean = 0.0, square = 0;  // of l
};

Sums sums_of(const std::vector<Hypothesis>& hypotheses) {
  Sums sums;
  for (const Hypothesis& h : hypotheses) {
    const double w = std::exp(h.log_weight), l = h.x[row::kSlip];
    if (h.mode != Mode::kGrips) sums.slips += w;
    sums.mean += w * l;
    sums.square += w * (l * l + h.P(row::kSlip, row::kSlip));
  }
  return sums;
}

TEST(Prune, KeepsTheProbabilityOfManyThatAreUnlikelyEach) {
  std::vector<Hypothesis> hypotheses(1);
  hypotheses[0].log_weight = std::log(0.4);
  for (int i = 0; i < 20; ++i) {
    Hypothesis h;
    h.mode = Mode::kChanges;
    h.set_slip(0.05 * (i - 4), 0.01);
    h.log_weight = std::log(0.6 * (20 + i) / 590);
    hypotheses.push_back(h);
  }
  const Sums before = sums_of(hypotheses);
  ASSERT_NEAR(before.slips, 0.6, 1e-9);
  prune(hypotheses, 5);
  EXPECT_EQ(hypotheses.size(), 5U);
  const Sums after = sums_of(hypotheses);
  EXPECT_NEAR(after.slips, before.slips, 1e-9);
  EXPECT_NEAR(after.mean, before.mean, 1e-9);
  EXPECT_NEAR(after.square, before.square, 1e-9);
}

}  // namespace
}  // namespace gprodom::slip
