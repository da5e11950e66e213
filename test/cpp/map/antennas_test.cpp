// Ground that one antenna has seen, found again by another one at another place of the robot.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "driven_ground.h"
#include "gpr/synthetic_ground.h"
#include "map/mapper.h"
#include "straight_robot.h"

namespace gprodom {
namespace {

constexpr double kFront = 0.3, kRear = -0.2;  // m

TEST(Antennas, RevisitsGoOnWithTheOtherOneFromItsOwnPlace) {
  Config config = default_config();
  config.gpr.antennas = {{0, {kFront, 0, 0}}, {1, {kRear, 0, 0}}};
  config.gpr.lever_arm = config.gpr.antennas[0];
  Mapper mapper(config, std::nullopt, std::nullopt);
  StraightRobot robot(mapper);
  robot.drive({0.0, 15.0, 0, kFront});
  robot.drive({15.0, 4.0, 0, kFront});
  robot.revisits = 0;
  const MapAnswer answer = robot.drive({4.0, 14.0, 1, kRear});
  EXPECT_GT(robot.revisits, 20U);
  ASSERT_TRUE(answer.pose);
  const PlanarPose& in_odom = answer.pose->in_odom.pose;
  EXPECT_NEAR(answer.pose->in_map.pose.p.x(), in_odom.p.x(), 0.05);

  // The ground of each antenna is a session, which tells its place, and is gone on with.
  robot.drive({14.0, 20.0, 0, kFront});
  robot.drive({20.0, 24.0, 1, kRear});
  const GroundMap ground = mapper.take_ground();
  ASSERT_EQ(ground.origins.size(), 2U);
  EXPECT_EQ(ground.origins[0].antenna.x(), kFront);
  EXPECT_EQ(ground.origins[1].antenna.x(), kRear);
  EXPECT_EQ(ground.antenna_at(0, {}).p.x(), kFront);
  EXPECT_EQ(ground.antenna_at(ground.memory.kept().end - 1, {}).p.x(), kRear);
  EXPECT_EQ(ground.origins[1].antenna_id, 1);
}

// Another robot, with its antenna elsewhere, in the map that the first one has made.
TEST(Antennas, AMapIsOfTheRobotsThatMadeIt) {
  Config config = default_config();
  config.gpr.lever_arm = {kFront, 0, 0};
  Mapper first(config, std::nullopt, std::nullopt);
  StraightRobot(first).drive({0.0, 20.0, 0, kFront});
  GroundMap made = reloaded(first.take_ground());

  config.gpr.lever_arm = {kRear, 0, 0};
  Mapper second(config, std::move(made), std::nullopt);
  StraightRobot robot(second);
  robot.drive({3.0, 19.0, 0, kRear, -3.0});
  ASSERT_TRUE(robot.located);
  EXPECT_NEAR(second.map_from_odom().p.x(), 3.0, 0.1);
}

// Ground that changes across the track: two traces whose echoes have a correlation of
// cos(distance / 0.15 m).
GprTrace seen(gpr::SyntheticRadar& radar, double x, double y, double seconds) {
  static const gpr::SyntheticGround kOne(7, 24.0), kOther(8, 24.0);
  GprTrace trace = radar.measure(kOne, x, seconds);
  const std::vector<double> one = kOne.trace(x), other = kOther.trace(x);
  for (std::size_t i = 0; i < one.size(); ++i)
    trace.samples[i] +=
        static_cast<float>((std::cos(y / 0.15) - 1.0) * one[i] + std::sin(y / 0.15) * other[i]);
  return trace;
}

// Two antennas abreast. The second lap is aside of the first one, which the odometry does not say.
TEST(Antennas, AbreastOnesTellToWhichSideTheRobotIs) {
  const double half = 0.1;  // m, from the middle to each antenna
  const auto found_aside = [&](double aside, bool both) {
    Config config = default_config();
    config.gpr.antennas = {{0, {0, half, 0}}, {1, {0, -half, 0}}};
    config.gpr.lever_arm = config.gpr.antennas[0];
    Mapper mapper(config, std::nullopt, std::nullopt);
    gpr::SyntheticRadar radar(3, 60.0);
    double seconds = 1000.0, found = 0.0;
    int driven = 0;
    for (const int lap : {1, 2}) {
      const double y = lap == 1 ? 0.0 : aside;
      MapInput input;
      for (double x = 0.0; x < 18.0; x += 0.1, seconds += 0.2, ++driven) {
        PathState state = state_at(from_seconds(seconds), x, 2e-4 * driven);
        state.covariance(2, 2) = state.pose_covariance(2, 2) = 1e-8 * driven;
        input.states.push_back(state);
        for (int k = 2; k >= 0 && x > 0.0; --k) {
          const double at_s = seconds - k * 0.2 / 3, at_x = x - k * 0.1 / 3;
          input.traces.push_back(seen(radar, at_x, y + half, at_s));
          if (!both) continue;
          input.beside.push_back(seen(radar, at_x, y - half, at_s));
          input.beside.back().antenna_id = 1;
        }
        if (driven % 10 < 9) continue;
        const MapAnswer answer = mapper.run(input);
        if (answer.pose) found = answer.pose->in_map.pose.p.y() - answer.pose->in_odom.pose.p.y();
        input = {};
      }
      seconds += 100.0;
    }
    return found;
  };
  EXPECT_NEAR(found_aside(0.1, false), 0.0, 0.03) << "one antenna tells no side";
  EXPECT_NEAR(found_aside(0.1, true), 0.1, 0.05);
  EXPECT_NEAR(found_aside(0.05, true), 0.05, 0.05);
  EXPECT_NEAR(found_aside(-0.1, true), 0.0, 0.03) << "the other one sees nothing known";
}

}  // namespace
}  // namespace gprodom
