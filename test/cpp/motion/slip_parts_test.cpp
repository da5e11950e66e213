// What SlipBelief is made of.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "motion/slip/error_tail.h"
#include "motion/slip/ground_noise.h"
#include "motion/slip/slip_hypothesis.h"
#include "motion/slip/slip_share.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using namespace slip;

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

TEST(SlipShare, IsLearntWhereSlipWouldBeSeen) {
  SlipShare share(0.3);
  EXPECT_DOUBLE_EQ(share.value(), 0.3);
  for (int i = 0; i < 600; ++i) share.add(1.0, i % 10 == 0 ? 1.0 : 0.0, 1.0);
  EXPECT_NEAR(share.value(), 0.11, 0.01);
}

// Where nothing would show slip, its probability stays low whatever the wheel does.
TEST(SlipShare, StaysWhereNoSlipWouldBeSeen) {
  SlipShare share(0.3);
  for (int i = 0; i < 600; ++i) share.add(1.0, 0.0, 0.01);
  EXPECT_GT(share.value(), 0.24);
}

TEST(SlipShare, AnEarlierRunCountsForTwoMinutes) {
  SlipShare before(0.3), share(0.3);
  for (int i = 0; i < 3600; ++i) before.add(1.0, 0.0, 1.0);
  share.take_up(before.counts());
  EXPECT_NEAR(share.value(), 0.3 * 30 / 150, 1e-9);
  for (int i = 0; i < 120; ++i) share.add(1.0, 1.0, 1.0);
  EXPECT_NEAR(share.value(), (0.3 * 30 + 120) / 270, 1e-9);
  share.take_up({0.0, 0.0});
  EXPECT_NEAR(share.value(), (0.3 * 30 + 120) / 270, 1e-9);
}

// Spans of 0.4 m on ground whose length changes from place to place, seen with an error a span. On
// every other stretch of 8 m the wheel slips.
GroundNoise after_drive(double place_sigma, double span_sigma, double slip, int seed) {
  constexpr double kSpan_m = 0.4, kStretch_m = 8.0;
  Noise normal(static_cast<unsigned>(seed));
  const double kept = std::exp(-kSpan_m / GroundNoise::kPlace);
  double place = place_sigma * normal();
  GroundNoise noise;
  for (double at = 0.0; at < 80.0; at += kSpan_m) {
    const bool slips = std::fmod(at, 2 * kStretch_m) > kStretch_m;
    noise.add(at, 2.0 + place + span_sigma * normal() + (slips ? slip : 0.0));
    place = kept * place + place_sigma * std::sqrt(1 - kept * kept) * normal();
  }
  return noise;
}

// The scatter of all spans is 0.27 where the wheel slips. Little of that may pass for the ground: a
// ground that scatters as much hides the slip. Slips that begin within a span are the hard case.
TEST(GroundNoise, IsLearntWhereTheWheelSlipsHalfOfTheWay) {
  for (const double slip : {0.0, -0.4}) {
    double place = 0.0, span = 0.0;
    constexpr int kDrives = 20;
    for (int seed = 0; seed < kDrives; ++seed) {
      const GroundNoise noise = after_drive(0.15, 0.1, slip, seed);
      place += noise.place_sigma() / kDrives;
      span += noise.span_sigma() / kDrives;
    }
    EXPECT_NEAR(place, 0.15, 0.07) << "slip " << slip;
    EXPECT_NEAR(span, 0.1, 0.04) << "slip " << slip;
  }
}

// Errors size |z|^exponent standard deviations, of which a share has another, larger size.
double threshold_after(int count, double size, double exponent, double share = 0.0,
                       double larger = 0.0) {
  std::mt19937 engine(3);
  std::normal_distribution<double> z;
  std::uniform_real_distribution<double> slips;
  ErrorTail tail;
  for (int i = 0; i < count; ++i) {
    const double error =
        slips(engine) < share ? larger : size * std::pow(std::abs(z(engine)), exponent);
    tail.add(error * error);
  }
  return tail.threshold(5.0);
}

TEST(ErrorTail, NormalErrorsKeepTheThreshold) {
  EXPECT_EQ(ErrorTail().threshold(5.0), 5.0);
  EXPECT_LT(threshold_after(600, 1.0, 1.0), 6.0);
  EXPECT_EQ(threshold_after(600, 0.3, 1.0), 5.0);  // smaller than assumed: no less evidence
}

TEST(ErrorTail, HeavyTailsAndTooSmallADeviationRaiseIt) {
  EXPECT_NEAR(threshold_after(600, 3.0, 1.0), 15.0, 3.0);
  EXPECT_NEAR(threshold_after(600, 1.5, 2.0), 1.5 * 25.0, 10.0);
}

TEST(ErrorTail, SlipsInLessThanATenthOfTheIntervalsDoNotCount) {
  EXPECT_LT(threshold_after(600, 1.0, 1.0, 0.05, 30.0), 8.0);
}

// Wheel and IMU of a simulation may agree exactly.
TEST(ErrorTail, ErrorsOfZeroAndOnesThatAreNotFinite) {
  ErrorTail tail;
  for (int i = 0; i < 1000; ++i) tail.add(0.0);
  tail.add(std::nan(""));
  EXPECT_EQ(tail.threshold(5.0), 5.0);
}

}  // namespace
}  // namespace gprodom
