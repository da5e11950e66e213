// States that the window hands to the pose graph.
#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "estimation/driven_intervals.h"

namespace gprodom {
namespace {

// The pose graph takes a state after a second, and waits four while a measurement is to come. With
// each it learns where the one that it took last lies now, also if others were left out between.
TEST(Settled, StatesWaitForMeasurementsToCome) {
  std::mt19937 random(4);
  StateEstimator estimator = at_ten_seconds(kSpeed);
  std::optional<NavState> before;
  for (int i = 0; i < 100; ++i) {
    StateInput input = interval(10.0 + kStateInterval * i, {kSpeed, 0.0}, random);
    const bool waits = i >= 40 && i < 60;
    if (waits) input.keep_since = from_seconds(10.0 + kStateInterval * 40);
    const StateResult result = estimator.add(input);
    ASSERT_TRUE(result.settled);
    if (i >= 60 || (i > 5 && i < 40)) {
      EXPECT_NEAR(to_seconds(result.state.time - result.settled->time), 1.0, 1e-6) << i;
    } else if (i == 59) {
      EXPECT_NEAR(to_seconds(result.state.time - result.settled->time), 4.0, 1e-6);
    }
    if (before) {
      ASSERT_TRUE(result.before_settled) << i;
      EXPECT_EQ(result.before_settled->time, before->time) << i;
      EXPECT_GE(result.settled->time, before->time) << i;
    }
    before = result.settled;
  }
}

}  // namespace
}  // namespace gprodom
