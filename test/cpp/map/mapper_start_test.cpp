// A track that goes on from a saved pose: how surely it lies in the map is what it was then, and
// what the odometry has lost since.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "map/mapper.h"

namespace gprodom {
namespace {

constexpr double kStep = 0.1;              // m from state to state
constexpr TimeNs kInterval = 200'000'000;  // ns
constexpr int kWay = 100;                  // states, there and back each

TimeNs time_of(int i) { return from_seconds(1000.0) + i * kInterval; }

// 10 m ahead, and backwards again.
PathState state(int i) {
  PathState at;
  at.time = time_of(i);
  at.pose.p.x() = kStep * (i < kWay ? i : 2 * kWay - i);
  at.covariance = 1e-5 * i * Eigen::Matrix3d::Identity();
  at.pose_covariance = at.covariance;
  return at;
}

// At the place of state `to` on the way back, the robot is where it was on the way there.
Displacement seen_again(int to) {
  Displacement revisit;
  revisit.kind = DisplacementKind::kRevisit;
  revisit.from = time_of(2 * kWay - to);
  revisit.to = time_of(to);
  revisit.sigma_m = 0.01;
  revisit.mirrored = true;
  revisit.valid = true;
  return revisit;
}

MapAnswer answer_of(const std::optional<Mapper::Start>& start, bool with_revisit) {
  Mapper mapper(default_config(), std::nullopt, start);
  MapInput input;
  for (int i = 0; i < 2 * kWay; ++i) input.states.push_back(state(i));
  if (with_revisit) input.revisits.push_back(seen_again(kWay + 50));
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

}  // namespace
}  // namespace gprodom
