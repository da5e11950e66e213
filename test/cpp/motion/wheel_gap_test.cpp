#include "motion/wheel_gap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gprodom {
namespace {

constexpr double kInterval = 0.2;

struct Drive {
  WheelHistory wheel{0.0};
  WheelGap gap;
  double time = 0.0;

  // Samples at 50 Hz, none while the wheel is silent, and the intervals that they belong to.
  std::vector<StateInput> run(double until, double silent_from, double silent_to,
                              double restarts_at = 1e9) {
    std::vector<StateInput> inputs;
    double next_sample = 0.0;
    while (time < until - 1e-9) {
      const double to = time + kInterval;
      for (; next_sample <= to + 0.1; next_sample += 0.02) {
        if (next_sample > silent_from && next_sample < silent_to) continue;
        const double distance = next_sample - (next_sample > restarts_at ? restarts_at : 0.0);
        wheel.insert({from_seconds(next_sample), distance});
      }
      StateInput input;
      input.time = from_seconds(to);
      input.steps.resize(1);
      input.steps[0].dt = kInterval;
      input.has_wheel = set_wheel_distances(input.steps, wheel, from_seconds(time), false);
      gap.complete(input, from_seconds(time), wheel, SlipModel());
      inputs.push_back(input);
      time = to;
    }
    return inputs;
  }
};

TEST(WheelGap, KeepsItsStatesAndTellsTheCountOnce) {
  Drive drive;
  int counts = 0;
  for (const StateInput& input : drive.run(30.0, 10.1, 15.5)) {
    const double to = to_seconds(input.time);
    EXPECT_EQ(input.keep_since.has_value(), to > 10.1 && to < 16.3) << to;
    if (!input.counted) continue;
    ++counts;
    EXPECT_NEAR(to_seconds(input.counted->from), 10.0, 1e-6);
    EXPECT_NEAR(to_seconds(input.counted->to), 15.6, 1e-6);
    EXPECT_NEAR(input.counted->counted_m, 5.6, 1e-6);
    EXPECT_NEAR(input.counted->restarted_m, 15.6, 1e-6);
  }
  EXPECT_EQ(counts, 1);
}

// Its distance goes on from the false increment; the count tells that.
TEST(WheelGap, TellsTheCountOfAnEncoderThatHasBegunAnew) {
  Drive drive;
  for (const StateInput& input : drive.run(30.0, 10.1, 15.5, 12.0)) {
    if (!input.counted) continue;
    EXPECT_NEAR(input.counted->counted_m, 5.6 - 12.0, 1e-6);
    EXPECT_NEAR(input.counted->restarted_m, 3.6, 1e-6);
    return;
  }
  FAIL() << "no count";
}

TEST(WheelGap, WithoutEndItKeepsNoStates) {
  Drive drive;
  const auto inputs = drive.run(60.0, 10.1, 1e9);
  EXPECT_FALSE(inputs.back().keep_since);
  EXPECT_FALSE(inputs.back().counted);
}

TEST(WheelGap, LearnsHowTheSpeedChanges) {
  WheelGap gap;
  EXPECT_EQ(gap.speed_change(), 0.0);
  double square = 0.0;
  int pairs = 0;
  for (int i = 0; i < 5000; ++i) {
    const double t = kInterval * i;
    gap.learn(std::sin(t), from_seconds(t));
    if (i < 5) continue;
    square += std::pow(std::sin(t) - std::sin(t - 1.0), 2);
    ++pairs;
  }
  EXPECT_NEAR(gap.speed_change(), std::sqrt(square / pairs), 0.01);
}

}  // namespace
}  // namespace gprodom
