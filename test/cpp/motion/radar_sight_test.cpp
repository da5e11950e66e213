// The judge learns the least speed that the radar sees, and uses it in its decisions.
#include <gtest/gtest.h>

#include "motion/judged_robot.h"

namespace gprodom {
namespace {

TEST(RadarSight, IsLearntFromDrivingAndDoesNotContradictASlowerWheel) {
  Config config;
  config.wheel.slip_threshold = 0;  // the radar alone knows
  for (const double times_least : {100.0, 2.0}) {
    Robot robot(config);
    robot.speed = robot.wheel_speed = kSpeed;
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
