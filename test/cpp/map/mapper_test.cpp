// What a mapper makes of a track: one that goes on from a saved pose, one that is lost, and one of
// a robot with two antennas.
#include "map/mapper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "driven_ground.h"
#include "gpr/synthetic_ground.h"
#include "straight_robot.h"

namespace gprodom {
namespace {

// A track that goes on from a saved pose: how surely it lies in the map is what it was then, and
// what the odometry has lost since.

constexpr double kStep = 0.1;              // m from state to state
constexpr TimeNs kInterval = 200'000'000;  // ns
constexpr int kWay = 100;                  // states, there and back each

TimeNs time_of(int i) { return from_seconds(1000.0) + i * kInterval; }

// 10 m ahead, and backwards again.
PathState state(int i) {
  return state_at(time_of(i), kStep * (i < kWay ? i : 2 * kWay - i), 1e-5 * i);
}

MapAnswer answer_of(const std::optional<TrackStart>& start, bool with_revisit) {
  Mapper mapper(default_config(), std::nullopt, start);
  MapInput input;
  for (int i = 0; i < 2 * kWay; ++i) input.states.push_back(state(i));
  if (with_revisit)
    input.revisits.push_back(seen_again(time_of(50), time_of(150), true));  // back there
  input.scale_sigma = 0.01;
  return mapper.run(input);
}

TrackStart known_to(double sigma) {
  TrackStart start;
  start.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-6).asDiagonal();
  return start;
}

TEST(MapperStart, ARevisitOfTheOwnTrackDoesNotTellWhereItBegan) {
  const MapAnswer without = answer_of(known_to(1.0), false), with = answer_of(known_to(1.0), true);
  EXPECT_GT(without.sigma_m, std::sqrt(2.0));
  ASSERT_TRUE(with.pose && with.pose->revisits == 1);
  EXPECT_GT(with.sigma_m, std::sqrt(2.0));
}

TEST(MapperStart, ATrackOfItsOwnBeginsWhereItsMapDoes) {
  const MapAnswer with = answer_of(std::nullopt, true);
  ASSERT_TRUE(with.pose && with.pose->revisits == 1);
  EXPECT_LT(with.sigma_m, 0.2);
}

// The first state of the new run has lost 2 m in the pause.
TEST(MapperStart, WhatThePauseHasCostIsAdded) {
  TrackStart start = known_to(1.0);
  start.since = state(0);
  Mapper mapper(default_config(), std::nullopt, start);
  MapInput input;
  for (int i = 0; i < kWay; ++i) {
    input.states.push_back(state(i));
    input.states.back().pose_covariance.diagonal().head<2>().array() += 4.0;
  }
  const MapAnswer answer = mapper.run(input);
  EXPECT_GT(answer.sigma_m, std::sqrt(2.0 * (1.0 + 4.0)));
}

// What the solutions of the pose graph cost in a second of data, where the track is tied to itself
// more and more densely.
constexpr double kSpeed = 1.0;            // m/s, straight ahead
constexpr TimeNs kNodes = 500'000'000;    // ns from state to state: each is a node
constexpr int kAlone = 600, kTied = 200;  // states before the first revisit, and since then
constexpr int kTies = 24;                 // revisits told for a state
constexpr double kWorkPerSecond = 5e7;    // multiplications, NormalMatrix::work()

TimeNs node_time(int state) { return from_seconds(1000.0) + state * kNodes; }

// That a state lies as far from an earlier one as it does, as another process tells it.
Displacement tie(int from, int to) {
  Displacement revisit = seen_again(node_time(from), node_time(to), false);
  revisit.distance_m = kSpeed * to_seconds(revisit.to - revisit.from);
  return revisit;
}

// The ties join places of the whole track, so the factor of the normal equations fills up, and
// what a solution costs grows far faster than the number of its nodes.
TEST(MapperWork, OfASecondIsBoundedWhereTheTrackIsTiedToItselfMoreAndMore) {
  Mapper mapper(default_config(), std::nullopt, std::nullopt);
  std::mt19937 random(1);
  double dearest = 0.0;
  int solutions = 0;
  bool located = false;
  for (int i = 0; i < kAlone + kTied; ++i) {
    MapInput input;
    input.states.push_back(state_at(node_time(i), kSpeed * i * to_seconds(kNodes), 1e-6 * i));
    for (int k = 0; k < kTies && i >= kAlone; ++k)
      input.revisits.push_back(tie(static_cast<int>(random() % static_cast<unsigned>(i - 10)), i));
    const double before = mapper.track().solve_work();
    located = mapper.run(input).pose.has_value();
    const double work = mapper.track().solve_work() - before;
    if (work > 0.0) ++solutions;
    dearest = std::max(dearest, work);
  }
  // Solved each second, all of them together would cost more than twice as much.
  EXPECT_TRUE(located);
  ASSERT_GT(dearest, 2.0 * kWorkPerSecond);
  EXPECT_GT(solutions, 2);
  const double seconds = to_seconds(kTied * kNodes);
  EXPECT_LT(mapper.track().solve_work(), kWorkPerSecond * seconds + dearest);
}

// A track that is lost: in an earlier map, and on its own ground.

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

// Ground that one antenna has seen, found again by another one at another place of the robot.

constexpr double kFront = 0.3, kRear = -0.2;  // m

TEST(Antennas, RevisitsGoOnWithTheOtherOneFromItsOwnPlace) {
  Mapper mapper(default_config({"gpr.antennas={0: [0.3, 0, 0], 1: [-0.2, 0, 0]}"}), std::nullopt,
                std::nullopt);
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
  EXPECT_NEAR(second.track().map_from_odom().p.x(), 3.0, 0.1);
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
    Mapper mapper(default_config({"gpr.antennas={0: [0, 0.1, 0], 1: [0, -0.1, 0]}"}), std::nullopt,
                  std::nullopt);
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
