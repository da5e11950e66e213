// What the judge tells the prediction of the wheel since a state.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "estimation/drive_traits.h"
#include "estimation/increments/wheel_increment.h"
#include "motion/judged_robot.h"
#include "motion/motion_judge.h"
#include "motion/wheel_gap.h"

namespace gprodom {
namespace {

// The way of the last interval: 0.1 m forwards, and the turn that is given.
PredictedWay last_way(const Robot& robot, double turned_rad) {
  PredictedWay way;
  way.time = from_seconds(robot.now());
  way.moved_m.x() = 0.1;
  way.turned_rad = turned_rad;
  return way;
}

std::optional<WheelWaySince> wheel_of(const Robot& robot, const PredictedWay& way) {
  return robot.judge.wheel_since(way.time - kInterval, way, way.time);
}

TEST(WheelSince, AWheelThatIsContradictedOrSilentStillHoldsThePredictionSideways) {
  Robot robot({}, kSpeed);
  robot.vibration = 3.0;
  robot.drive(10);
  const auto trusted = wheel_of(robot, last_way(robot, 0.0));
  ASSERT_TRUE(trusted);
  EXPECT_NEAR(trusted->moved_m.x(), kSpeed * to_seconds(kInterval), 1e-4);
  EXPECT_LT(trusted->sigma_m.x(), 0.05);

  robot.wheel_speed = 2 * kSpeed;
  robot.drive(4);
  const auto slips = wheel_of(robot, last_way(robot, 0.0));
  robot.wheel_speed = kSpeed;
  robot.drive(5);
  robot.wheel_speaks = false;
  robot.drive(2);
  const auto silent = wheel_of(robot, last_way(robot, 0.0));
  for (const auto& doubted : {slips, silent}) {
    ASSERT_TRUE(doubted);
    EXPECT_EQ(doubted->moved_m.x(), 0.1);  // of the prediction itself
    EXPECT_EQ(doubted->sigma_m.x(), kUnknownDistanceSigma_m);
    EXPECT_NEAR(doubted->sigma_m.y(), trusted->sigma_m.y(), 1e-5);
    EXPECT_NEAR(doubted->sigma_m.z(), trusted->sigma_m.z(), 1e-5);
  }
}

// Two antennas have measured that the robot goes three times as far as the wheel says: the pose
// between two states goes on so, too.
TEST(WheelSince, TheSlipThatIsKnownGoesOn) {
  Robot robot(default_config({"gpr.antennas={0: [0.15, 0, 0], 1: [-0.15, 0, 0]}"}), kSpeed);
  robot.wheel_speed = kSpeed / 3;
  robot.vibration = 3.0;
  robot.drive(10);
  const double to = robot.now() - 0.3;
  const TimeNs from = from_seconds(to - 0.3 / kSpeed);
  robot.judge.add_passage({from, from_seconds(to), {0.15, 0, 0}, {-0.15, 0, 0}, 0.003});
  robot.drive(1);
  const auto wheel = wheel_of(robot, last_way(robot, 0.0));
  ASSERT_TRUE(wheel);
  const double way_m = kSpeed * to_seconds(kInterval);
  EXPECT_NEAR(wheel->moved_m.x(), way_m, 0.02 * way_m);
  EXPECT_GT(wheel->sigma_m.x(), 0.1 * way_m) << "it may have changed since";
}

// A tyre's slip angle is the lateral force over weight and cornering stiffness, v w / (g C), and
// the robot creeps by that angle times its way.
TEST(WheelSince, ASingleWheelCreepsSidewaysInABend) {
  Robot robot({}, kSpeed);
  robot.vibration = 3.0;
  robot.drive(10);
  constexpr double kTurn = 0.3;  // rad
  const double rate = kTurn / to_seconds(kInterval), way_m = kSpeed * to_seconds(kInterval);
  const auto straight = wheel_of(robot, last_way(robot, 0.0)),
             bend = wheel_of(robot, last_way(robot, kTurn));
  ASSERT_TRUE(straight && bend);
  const double angle = kSpeed * rate / (9.8 * kCorneringStiffness);
  const double more =
      std::sqrt(std::pow(bend->sigma_m.y(), 2) - std::pow(straight->sigma_m.y(), 2));
  EXPECT_NEAR(more, angle * way_m, 1e-3 * angle * way_m);
  EXPECT_EQ(bend->sigma_m.x(), straight->sigma_m.x());
}

TEST(WheelSince, NoWheelIsTakenWhereTheRobotStandsOrTheImuWasSilent) {
  Robot robot;
  robot.drive(5);
  EXPECT_FALSE(wheel_of(robot, last_way(robot, 0.0)));  // stands
  robot.speed = robot.wheel_speed = kSpeed;
  robot.vibration = 3.0;
  robot.newest.bridged = true;
  robot.drive(5);
  EXPECT_FALSE(wheel_of(robot, last_way(robot, 0.0)));
  robot.newest.bridged = false;
  robot.drive(1);
  EXPECT_TRUE(wheel_of(robot, last_way(robot, 0.0)));
}

constexpr double kInterval_s = to_seconds(kInterval);

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
      const double to = time + kInterval_s;
      for (; next_sample <= to + 0.1; next_sample += 0.02) {
        if (next_sample > silent_from && next_sample < silent_to) continue;
        const double distance = next_sample - (next_sample > restarts_at ? restarts_at : 0.0);
        wheel.insert({from_seconds(next_sample), distance});
      }
      StateInput input;
      input.time = from_seconds(to);
      input.steps.resize(1);
      input.steps[0].dt = kInterval_s;
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
    const double t = kInterval_s * i;
    gap.learn(std::sin(t), from_seconds(t));
    if (i < 5) continue;
    square += std::pow(std::sin(t) - std::sin(t - 1.0), 2);
    ++pairs;
  }
  EXPECT_NEAR(gap.speed_change(), std::sqrt(square / pairs), 0.01);
}

}  // namespace
}  // namespace gprodom
