// A track that is lost: in an earlier map, and on its own ground.
#include <gtest/gtest.h>

#include "driven_ground.h"
#include "map/mapper.h"
#include "straight_robot.h"

namespace gprodom {
namespace {

// The map knows by how much odom is ahead, m.
void expect_found(const MapAnswer& answer, double ahead_m) {
  ASSERT_TRUE(answer.pose);
  EXPECT_NEAR(answer.pose->in_map.pose.p.x(), answer.pose->in_odom.pose.p.x() - ahead_m, 0.2);
  EXPECT_LT(answer.sigma_m, 0.5);
}

// The wheel jumps by more than is searched about the robot, and the covariance says so.
TEST(Lost, TrackIsFoundAgainInItsMap) {
  const Config config = default_config();
  Mapper first(config, std::nullopt, std::nullopt);
  StraightRobot(first).drive({0.0, 50.0});
  Mapper second(config, reloaded(first.take_ground()), std::nullopt);
  StraightRobot robot(second);
  robot.drive({0.0, 16.0});
  ASSERT_TRUE(robot.located);
  robot.lost_m2 = 36.0;
  const MapAnswer answer = robot.drive({16.0, 48.0, 0, 0.0, 9.0});
  expect_found(answer, 9.0);
}

// A loop of which the odometry has lost more than is searched about the robot.
TEST(Lost, TrackIsFoundOnItsOwnGround) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  StraightRobot robot(mapper);
  robot.drive({0.0, 50.0});
  robot.lost_m2 = 36.0;
  const MapAnswer answer = robot.drive({50.0, 2.0, 0, 0.0, 9.0});
  expect_found(answer, 9.0);
}

// New ground that looks like none before: no place is found, however far the odometry is off.
TEST(Lost, NewGroundIsNotTakenForOwnGround) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  StraightRobot robot(mapper);
  robot.drive({0.0, 25.0});
  robot.lost_m2 = 36.0;
  robot.drive({25.0, 58.0});
  EXPECT_EQ(robot.revisits, 0U);
}

// The ground of earlier tracks without that of the present one.
TEST(EarlierGround, IsWhatWasThereBeforeTheTrack) {
  const auto before = [] {
    Mapper first(default_config(), std::nullopt, std::nullopt);
    StraightRobot(first, 1, 1000.0).drive({0.0, 20.0});
    return first.take_ground();
  };
  const auto columns = before().memory.kept().size();
  ASSERT_GT(columns, 500U);

  Mapper second(default_config(), before(), std::nullopt);
  StraightRobot(second, 2, 2000.0).drive({0.0, 20.0});
  const GroundMap all = second.take_ground();
  EXPECT_GT(all.memory.kept().size(), columns + 500);

  Mapper third(default_config(), before(), std::nullopt);
  StraightRobot(third, 2, 2000.0).drive({0.0, 20.0});
  const GroundMap earlier = third.take_earlier_ground();
  EXPECT_EQ(earlier.memory.kept().size(), columns);
  EXPECT_EQ(earlier.places.size(), before().places.size());

  Mapper alone(default_config(), std::nullopt, std::nullopt);
  StraightRobot(alone, 3, 3000.0).drive({0.0, 20.0});
  EXPECT_EQ(alone.take_earlier_ground().memory.kept().size(), 0U);
}

}  // namespace
}  // namespace gprodom
