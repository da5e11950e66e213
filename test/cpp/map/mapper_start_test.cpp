// A track that goes on from a saved pose: how surely it lies in the map is what it was then, and
// what the odometry has lost since.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "map/mapper.h"
#include "straight_robot.h"

namespace gprodom {
namespace {

constexpr double kStep = 0.1;              // m from state to state
constexpr TimeNs kInterval = 200'000'000;  // ns
constexpr int kWay = 100;                  // states, there and back each

TimeNs time_of(int i) { return from_seconds(1000.0) + i * kInterval; }

// 10 m ahead, and backwards again.
PathState state(int i) {
  return state_at(time_of(i), kStep * (i < kWay ? i : 2 * kWay - i), 1e-5 * i);
}

MapAnswer answer_of(const std::optional<Mapper::Start>& start, bool with_revisit) {
  Mapper mapper(default_config(), std::nullopt, start);
  MapInput input;
  for (int i = 0; i < 2 * kWay; ++i) input.states.push_back(state(i));
  if (with_revisit)
    input.revisits.push_back(seen_again(time_of(50), time_of(150), true));  // back there
  input.scale_sigma = 0.01;
  return mapper.run(input);
}

Mapper::Start known_to(double sigma) {
  Mapper::Start start;
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
  Mapper::Start start = known_to(1.0);
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
    const double before = mapper.solve_work();
    located = mapper.run(input).pose.has_value();
    const double work = mapper.solve_work() - before;
    if (work > 0.0) ++solutions;
    dearest = std::max(dearest, work);
  }
  // Solved each second, all of them together would cost more than twice as much.
  EXPECT_TRUE(located);
  ASSERT_GT(dearest, 2.0 * kWorkPerSecond);
  EXPECT_GT(solutions, 2);
  const double seconds = to_seconds(kTied * kNodes);
  EXPECT_LT(mapper.solve_work(), kWorkPerSecond * seconds + dearest);
}

}  // namespace
}  // namespace gprodom
