#include "motion/pair_slip.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gprodom {
namespace {

Config two_antennas() {
  Config config;
  config.gpr.antennas = {{0, {0.15, 0, 0}}, {1, {-0.15, 0, 0}}};
  return config;
}

// 1 m/s.
WheelHistory rolling() {
  WheelHistory wheel(5.0);
  for (int i = 0; i <= 100; ++i) wheel.insert({from_seconds(10 + 0.1 * i), 0.1 * i});
  return wheel;
}

AntennaPassage passage(double from, double to) {
  AntennaPassage p;
  p.from = from_seconds(from);
  p.to = from_seconds(to);
  p.lever_from.x() = 0.3;
  p.sigma_m = 0.003;
  return p;
}

// A wheel of 1 m/s whose robot needs 0.6 s for 0.3 m: it slips by half.
TEST(PairSlip, IsTheDistanceOfTheAntennasOverThatOfTheWheel) {
  const WheelHistory wheel = rolling();
  PairSlip slip(two_antennas());
  const std::vector<IntervalSlip> before = {{from_seconds(14.5), 0.0, 0.01},
                                            {from_seconds(16), 0.0, 0.01}};
  EXPECT_FALSE(slip.knows(from_seconds(15)));
  EXPECT_EQ(slip.revise(before, from_seconds(16)).front().l, 0.0);
  slip.add(passage(14, 14.6), wheel, 1.0);
  ASSERT_TRUE(slip.knows(from_seconds(16)));
  const auto after = slip.revise(before, from_seconds(16));
  EXPECT_NEAR(after.front().l, std::log(0.5), 1e-6);
  EXPECT_LT(after.front().sigma, after.back().sigma) << "slip may have changed since";
  EXPECT_FALSE(slip.knows(from_seconds(20))) << "nothing is measured any more";
}

// As with wheel.slip_share: 0.
TEST(PairSlip, IsKnownWhereNothingElseFollowsSlip) {
  const WheelHistory wheel = rolling();
  PairSlip slip(two_antennas());
  EXPECT_EQ(slip.revise({}, from_seconds(14.5)).size(), 1U);
  slip.add(passage(14, 14.6), wheel, 1.0);
  const auto after = slip.revise({}, from_seconds(15));
  ASSERT_EQ(after.size(), 2U);
  EXPECT_NEAR(after.front().l, std::log(0.5), 1e-6);
}

TEST(PairSlip, WithOneAntennaTheSlipsStayAsTheyAre) {
  PairSlip slip{Config()};
  EXPECT_TRUE(slip.revise({}, from_seconds(14.5)).empty());
}

}  // namespace
}  // namespace gprodom
