// What the judge tells the prediction of the wheel since a state.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "estimation/drive_traits.h"
#include "estimation/increments/wheel_increment.h"
#include "motion/judged_robot.h"
#include "motion/motion_judge.h"

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
  Config config;
  config.gpr.antennas = {{0, {0.15, 0, 0}}, {1, {-0.15, 0, 0}}};
  Robot robot(config);
  robot.speed = kSpeed;
  robot.wheel_speed = kSpeed / 3;
  robot.vibration = 3.0;
  robot.drive(10);
  const double to = robot.now() - 0.3;
  AntennaPassage passage;
  passage.from = from_seconds(to - 0.3 / kSpeed);
  passage.to = from_seconds(to);
  passage.lever_from.x() = 0.15;
  passage.lever_to.x() = -0.15;
  passage.sigma_m = 0.003;
  robot.judge.add_passage(passage);
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

}  // namespace
}  // namespace gprodom
