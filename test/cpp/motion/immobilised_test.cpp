#include "motion/immobilised.h"

#include <gtest/gtest.h>

#include "motion/judged_robot.h"

namespace gprodom {
namespace {

constexpr double kDug_mps = 0.4, kCreeps_mps = 0.08;

// Has driven 4 m, on which the radar saw motion `times_least` times as fast as the slowest that it
// sees; then it rests. Sudden slip is not looked for, so that the flag has this cause alone.
struct Rested : Robot {
  explicit Rested(double times_least = 50.0) : Robot(default_config({"wheel.slip_threshold=0"})) {
    speed = wheel_speed = kSpeed;
    vibration = 20.0;
    for (int i = 0; i < 40; ++i) {
      next();
      if (i % 3 == 2)
        judge.add_sight({from_seconds(now() - 0.6), from_seconds(now()), times_least});
    }
    speed = wheel_speed = 0.0;
    vibration = 1.0;
    for (int i = 0; i < 25; ++i) standing();
    vibration = 20.0;  // as soon as the wheel turns
  }

  // The next interval, the radar seeing a standstill as late as it does.
  StateInput standing() { return standing_since(now() - 5.0); }

  StateInput standing_since(double since) {
    gpr::Standstill said = stood(now() - 0.4, now() - 0.2);
    said.since = from_seconds(std::max(since, kStart));
    receive(said);
    return next();
  }

  bool told() const { return (flags & kImmobilised) != 0; }
  void expect_untold(int intervals) {
    for (int i = 0; i < intervals; ++i) {
      standing();
      EXPECT_FALSE(told()) << i;
    }
  }
};

TEST(Immobilised, IsToldWhileTheWheelTurnsAndTheGroundStands) {
  for (const double wheel : {kDug_mps, -kDug_mps, kCreeps_mps}) {
    Rested robot;
    EXPECT_FALSE(robot.told());
    robot.wheel_speed = wheel;
    const double begin = robot.now();
    while (!robot.told() && robot.now() < begin + 5) robot.standing();
    const double late = robot.now() - begin;
    EXPECT_TRUE(late < 1.0 || late * std::abs(wheel) < 0.3) << wheel << " m/s: " << late << " s";

    const StateInput held = robot.standing();
    EXPECT_TRUE(held.wheel_contradicted);
    EXPECT_TRUE(held.standing || !held.displacements.empty());

    robot.wheel_speed = 0.0;
    for (int i = 0; i < 4; ++i) robot.standing();
    EXPECT_FALSE(robot.told()) << "the wheel has stopped";
  }
}

TEST(Immobilised, EndsWhenTheRadarNoLongerSeesAStandstill) {
  Rested robot;
  robot.wheel_speed = kDug_mps;
  for (int i = 0; i < 8; ++i) robot.standing();
  ASSERT_TRUE(robot.told());
  robot.speed = kDug_mps;
  robot.drive(8);
  EXPECT_FALSE(robot.told());
}

// Ground alike everywhere: the radar sees a standstill, the IMU how the robot gathers speed.
TEST(Immobilised, IsNotToldWhereTheImuFeelsTheRobotMove) {
  Rested robot;
  robot.acceleration = kDug_mps;  // for a second
  for (int i = 0; i < 5; ++i) {
    robot.wheel_speed += 0.2 * kDug_mps;
    robot.standing();
  }
  robot.acceleration = 0.0;
  robot.expect_untold(10);
  EXPECT_EQ(robot.judge.immobilised(), Immobilised::kCannotTell);
}

// The wheel slips, and the robot rolls on at less than half of its speed.
TEST(Immobilised, IsNotToldWhileTheWheelSlipsOnBlindGround) {
  Rested robot(1.0);
  robot.wheel_speed = robot.speed = kDug_mps;
  for (int i = 0; i < 15; ++i) {
    robot.drive(1);
    robot.judge.add_sight({from_seconds(robot.now() - 0.2), from_seconds(robot.now()), 1.0});
  }
  const double begin = robot.now();
  robot.wheel_speed = 2.5 * kDug_mps;
  for (int i = 0; i < 10; ++i) {
    robot.standing_since(begin);
    EXPECT_FALSE(robot.told());
  }
}

// At a creep the IMU cannot tell, and on such ground the radar saw no motion before either.
TEST(Immobilised, IsNotToldOnGroundThatLooksAlike) {
  Rested robot(1.0);
  robot.vibration = 200.0;
  robot.wheel_speed = kCreeps_mps;
  robot.expect_untold(25);
  EXPECT_EQ(robot.judge.immobilised(), Immobilised::kCannotTell);
}

// On textured ground a mute IMU is enough. But where the radar sees motion again although the wheel
// never stopped, the robot has rolled all along: the second such stretch is not reported.
TEST(Immobilised, LearnsFromAFlagThatProvedWrong) {
  Rested robot;
  robot.vibration = 200.0;
  const auto blind_stretch = [&robot] {
    const double begin = robot.now();
    bool told = false;
    for (int i = 0; i < 14; ++i) {
      robot.standing_since(begin);
      told = told || robot.told();
    }
    return told;
  };
  robot.wheel_speed = robot.speed = kCreeps_mps;
  EXPECT_TRUE(blind_stretch());
  for (int i = 0; i < 10; ++i) {
    robot.drive(3);
    robot.judge.add_sight({from_seconds(robot.now() - 0.6), from_seconds(robot.now()), 50.0});
  }
  EXPECT_FALSE(robot.told());
  EXPECT_FALSE(blind_stretch());
}

TEST(Immobilised, IsNotToldOfARobotThatTurnsOnTheSpot) {
  Rested robot;
  robot.wheel_speed = kDug_mps;
  robot.extra_rate = 0.3;
  robot.expect_untold(10);
}

// The judge learns the least speed that the radar sees, and uses it in its decisions.
TEST(RadarSight, IsLearntFromDrivingAndDoesNotContradictASlowerWheel) {
  const Config config = default_config({"wheel.slip_threshold=0"});  // the radar alone knows
  for (const double times_least : {100.0, 2.0}) {
    Robot robot(config, kSpeed);
    EXPECT_FALSE(robot.judge.unseen_speed());
    for (int i = 0; i < 20; ++i) {
      robot.drive(3);
      robot.judge.add_sight(
          {from_seconds(robot.now() - 0.6), from_seconds(robot.now()), times_least});
    }
    const double least = kSpeed / times_least;
    ASSERT_TRUE(robot.judge.unseen_speed());
    EXPECT_GT(*robot.judge.unseen_speed(), 1.1 * least);
    EXPECT_LT(*robot.judge.unseen_speed(), 2.0 * least);
    robot.speed = 0.0;
    robot.wheel_speed = 0.1;
    robot.drive(5);
    robot.receive(stood(robot.now() - 0.1, robot.now() + 0.3));
    EXPECT_EQ(robot.next().standing, times_least > 10) << times_least;
  }
}

}  // namespace
}  // namespace gprodom
