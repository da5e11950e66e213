#include "motion/pair_slip.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gprodom {
namespace {

Config two_antennas() {
  return default_config({"gpr.antennas={0: [0.15, 0, 0], 1: [-0.15, 0, 0]}"});
}

// A wheel of 1 m/s.
struct TwoAntennas : testing::Test {
  TwoAntennas() {
    for (int i = 0; i <= 100; ++i) wheel.insert({from_seconds(10 + 0.1 * i), 0.1 * i});
  }
  WheelHistory wheel{5.0};
  PairSlip slip{two_antennas()};
};

AntennaPassage passage(double from, double to) {
  return {from_seconds(from), from_seconds(to), {0.3, 0, 0}, {0, 0, 0}, 0.003};
}

// A wheel of 1 m/s whose robot needs 0.6 s for 0.3 m: it slips by half.
TEST_F(TwoAntennas, SlipIsTheDistanceOfTheAntennasOverThatOfTheWheel) {
  const std::vector<IntervalSlip> before = {{from_seconds(14.5), 0.0, 0.01},
                                            {from_seconds(16), 0.0, 0.01}};
  EXPECT_FALSE(slip.knows(from_seconds(15)));
  EXPECT_EQ(slip.revise(before, from_seconds(16)).front().l, 0.0);
  slip.add(passage(14, 14.6), wheel, 1.0);
  ASSERT_TRUE(slip.knows(from_seconds(16)));
  const auto after = slip.revise(before, from_seconds(16));
  EXPECT_NEAR(after.front().l, std::log(0.5), 1e-3);
  EXPECT_LT(after.front().sigma, after.back().sigma) << "slip may have changed since";
  EXPECT_FALSE(slip.knows(from_seconds(20))) << "nothing is measured any more";
}

// As with wheel.slip_share: 0.
TEST_F(TwoAntennas, SlipIsKnownWhereNothingElseFollowsSlip) {
  EXPECT_EQ(slip.revise({}, from_seconds(14.5)).size(), 1U);
  slip.add(passage(14, 14.6), wheel, 1.0);
  const auto after = slip.revise({}, from_seconds(15));
  ASSERT_EQ(after.size(), 2U);
  EXPECT_NEAR(after.front().l, std::log(0.5), 1e-3);
}

// What was measured stays so when the pair has been blind for a while.
TEST_F(TwoAntennas, SlipStaysKnownWhereItWasMeasured) {
  slip.add(passage(14, 14.6), wheel, 1.0);
  const std::vector<IntervalSlip> others = {{from_seconds(14.5), 0.0, 0.01},
                                            {from_seconds(19), 0.0, 0.01}};
  ASSERT_FALSE(slip.knows(from_seconds(19)));
  const auto after = slip.revise(others, from_seconds(19));
  EXPECT_NEAR(after.front().l, std::log(0.5), 1e-3);
  EXPECT_EQ(after.back().l, 0.0);
}

// A match of 6 cm beside 0.3 m, on a wheel that gripped before.
TEST_F(TwoAntennas, AWeakMatchTellsLittle) {
  const auto l_at = [&](double time) {
    return slip.revise({{from_seconds(time)}}, from_seconds(time)).back();
  };
  slip.add(passage(14, 14.3), wheel, 1.0);
  EXPECT_NEAR(l_at(14.2).l, 0.0, 1e-3);
  AntennaPassage weak = passage(15, 15.25);
  weak.sigma_m = 0.06;
  slip.add(weak, wheel, 1.0);
  EXPECT_LT(l_at(15.2).l, 0.02) << "0.18 by itself";
  slip.add(passage(16, 16.25), wheel, 1.0);
  EXPECT_NEAR(l_at(16.2).l, std::log(0.3 / 0.25), 2e-3);
}

// A robot of 4 cm/s, or one that stops on the way: others follow the slip of the last second alone.
TEST(PairSlip, OfALongPassageCountsForAllOfIt) {
  WheelHistory wheel(5.0);
  for (int i = 0; i <= 300; ++i) wheel.insert({from_seconds(10 + 0.1 * i), 0.008 * i});
  PairSlip slip(two_antennas());
  for (double end = 15.0; end < 30.0; end += 0.5) slip.revise({}, from_seconds(end));
  slip.add(passage(17, 24.5), wheel, 1.0);
  const auto after = slip.revise({{from_seconds(30.0), 0.0, 0.01}}, from_seconds(30.0));
  ASSERT_EQ(after.size(), 31U);
  for (const IntervalSlip& each : after) EXPECT_NEAR(each.l, std::log(0.5), 1e-3);
  EXPECT_TRUE(slip.knows(from_seconds(30))) << "the next one is not to be expected yet";
  EXPECT_GE(slip.memory(), from_seconds(30));
  EXPECT_EQ(PairSlip(Config()).memory(), 0);
}

TEST_F(TwoAntennas, TellWhereAPassageHasMeasuredThePath) {
  EXPECT_TRUE(std::isinf(slip.left(from_seconds(14)).value()));
  slip.add(passage(14, 14.6), wheel, 1.0);
  EXPECT_EQ(slip.left(from_seconds(14.1)), 0.0);
  EXPECT_EQ(slip.left(from_seconds(14.8)), 0.0) << "as far as half way to the next one";
  const double soon = slip.left(from_seconds(15)).value(),
               later = slip.left(from_seconds(17)).value();
  EXPECT_GT(soon, 0.02);
  EXPECT_LT(soon, later);
  EXPECT_LT(later, SlipModel().sigma());
  EXPECT_TRUE(std::isinf(slip.left(from_seconds(19)).value()));
}

TEST(PairSlip, WithOneAntennaTheSlipsStayAsTheyAre) {
  PairSlip slip{Config()};
  EXPECT_EQ(slip.left(from_seconds(14)), std::nullopt);
  EXPECT_TRUE(slip.revise({}, from_seconds(14.5)).empty());
}

}  // namespace
}  // namespace gprodom
