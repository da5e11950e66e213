// Two antennas in a row over made-up ground, of which the path is told wrongly: the pair must find
// the true times.
#include "gpr/pair/pair_front_end.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "gpr/synthetic_ground.h"

namespace gprodom::gpr {
namespace {

constexpr double kApart = 0.3;  // m between the antennas

GprConfig two_antennas() {
  GprConfig config;
  config.antennas = {{0, {0.15, 0, 0}}, {1, {-0.15, 0, 0}}};
  return config;
}

struct Drive {
  std::function<double(double)> place;  // m, of the robot at a time
  double told = 1.0;                    // distance told over the true one
  double seconds = 40.0;
  std::function<bool(double)> swapped = [](double) { return false; };  // at a time
  int ground = 1;
  double noise = 100.0;
  double speed_known_from = 0.0;                      // s; before, its sign is not certain
  std::function<double(double)> told_path = nullptr;  // in place of `told`
  std::function<double(double)> heading = [](double) { return 0.0; };  // rad, told
  std::function<double(double)> sigma_without_wheel = nullptr;         // m/s, of the told speed
};

struct Found {
  double error_m, sigma_m;
  double from_s, to_s;
};

// Errors of the passages' displacement, and the state at the end.
struct Result {
  std::vector<Found> passages;
  PairState state = PairState::kWaits;
  double first_s = 1e9, last_s = 0.0;  // ends of the first and last passage
  int given = 0;                       // all passages, also while it learns
  double first_given_s = 0.0;          // when the first of them was told
};

Result driven(const Drive& drive) {
  const SyntheticGround ground(drive.ground, 25.0);
  SyntheticRadar front(5, drive.noise), rear(6, drive.noise);
  PairFrontEnd pair(two_antennas(), antenna_row(two_antennas()).value());
  Result result;
  Travel travel;
  for (int i = 1; i < static_cast<int>(drive.seconds * 20); ++i) {
    const double t = 0.05 * i, s = drive.place(t);
    for (const bool is_front : {true, false}) {
      GprTrace trace =
          (is_front ? front : rear).measure(ground, s + (is_front ? 0.5 : -0.5) * kApart, t);
      if (!is_front) trace = by_other_antenna(trace, 4);  // 0.8 ns
      trace.antenna_id = is_front == drive.swapped(t) ? 1 : 0;
      pair.add_trace(trace);
    }
    if (i % 2 != 0) continue;
    const double told = drive.told_path ? drive.told_path(t) : drive.told * s;
    const double before = travel.empty() ? told : travel.points().back().s_m;
    travel.append({from_seconds(t), told, drive.heading(t)});
    const double sigma = t < drive.speed_known_from ? 0.3 : 0.01;
    const auto& alone = drive.sigma_without_wheel;
    travel.set_speed((told - before) / 0.1, alone ? alone(t) : sigma, !alone);
    for (const Passage& passage : pair.tick(from_seconds(t), travel)) {
      if (++result.given == 1) result.first_given_s = t;
      result.first_s = std::min(result.first_s, to_seconds(passage.to));
      if (pair.state() != PairState::kFollows) continue;
      const double moved =
          drive.place(to_seconds(passage.to)) - drive.place(to_seconds(passage.from));
      result.last_s = to_seconds(passage.to);
      result.passages.push_back({moved - passage.distance_m(), passage.sigma_m,
                                 to_seconds(passage.from), to_seconds(passage.to)});
    }
  }
  result.state = pair.state();
  return result;
}

double nees(const std::vector<Found>& passages) {
  double sum = 0;
  for (const Found& found : passages) sum += std::pow(found.error_m / found.sigma_m, 2);
  return sum / static_cast<double>(passages.size());
}

double mean(const std::vector<Found>& passages) {
  double sum = 0;
  for (const Found& found : passages) sum += found.error_m;
  return sum / static_cast<double>(passages.size());
}

// Backwards the rear antenna leads.
TEST(PairFrontEnd, FindsTheDistanceBothWaysWhateverTheToldPathSays) {
  const auto ahead = [](double t) { return 2.0 + 0.4 * t; };
  const auto back = [](double t) { return 22.0 - 0.4 * t; };
  for (const Drive& drive : {Drive{ahead}, {ahead, 1.25}, {ahead, 0.8}, {back}}) {
    SCOPED_TRACE(drive.place(1.0) - drive.place(0.0));
    const Result result = driven(drive);
    ASSERT_GT(result.passages.size(), 20U) << drive.told;
    EXPECT_NEAR(mean(result.passages), 0.0, 0.002) << drive.told;
    for (const Found& found : result.passages)
      EXPECT_LT(std::abs(found.error_m), std::max(0.02, 3 * found.sigma_m)) << drive.told;
  }
}

// The variance is not below that of the errors: the mean of the squares of 80 normal values is
// below 1.5 in 99.9 % of the cases. It may be above, as it has a least value (the path between two
// states), but not by a factor of ten.
TEST(PairFrontEnd, VarianceCoversTheErrors) {
  std::vector<Found> all;
  for (const int ground : {1, 2, 3, 4}) {
    Drive drive{[](double t) { return 2.0 + 0.4 * t; }};
    drive.ground = ground;
    const Result result = driven(drive);
    all.insert(all.end(), result.passages.begin(), result.passages.end());
  }
  ASSERT_GT(all.size(), 80U);
  EXPECT_GT(nees(all), 0.1);
  EXPECT_LT(nees(all), 1.5);
}

TEST(PairFrontEnd, AStopOnTheWayDoesNotMatter) {
  const auto place = [](double t) { return 2.0 + 0.4 * (t < 20.0 ? t : std::max(20.0, t - 6.0)); };
  const Result result = driven({place, 1.1});
  ASSERT_GT(result.passages.size(), 15U);
  EXPECT_NEAR(mean(result.passages), 0.0, 0.002);
}

// The ground goes on as if the antennas had gone straight on, so that it is alike; but a robot that
// has turned by a right angle at its stop passes beside the places where its front antenna was.
TEST(PairFrontEnd, NothingIsComparedAcrossATurnOnTheSpot) {
  Drive drive{[](double t) { return 2.0 + 0.4 * (t < 20.5 ? t : std::max(20.5, t - 4.0)); }};
  const auto over_the_stop = [](const Found& found) {
    return found.from_s < 20.5 && found.to_s > 24.5;
  };
  const Result straight = driven(drive);
  EXPECT_GT(std::count_if(straight.passages.begin(), straight.passages.end(), over_the_stop), 0);
  drive.heading = [](double t) { return 1.6 * std::clamp((t - 21.0) / 2.0, 0.0, 1.0); };
  const Result turned = driven(drive);
  EXPECT_EQ(std::count_if(turned.passages.begin(), turned.passages.end(), over_the_stop), 0);
  EXPECT_GT(turned.passages.size(), straight.passages.size() - 16);
  EXPECT_GT(turned.last_s, 35.0);
}

// A wheel that begins to spin at 2.5 times the speed.
TEST(PairFrontEnd, IsFoundAgainWhenTheToldSpeedJumps) {
  const auto told = [](double t) { return 0.4 * (t + 1.5 * std::max(0.0, t - 20.0)); };
  Drive drive{[](double t) { return 2.0 + 0.4 * t; }};
  drive.told_path = told;
  const Result result = driven(drive);
  // The path is never corrected here, so each passage takes three misses.
  EXPECT_GT(result.passages.size(), 12U);
  EXPECT_GT(result.last_s, 35.0);
  EXPECT_NEAR(mean(result.passages), 0.0, 0.003);
}

// A wheel that begins to skid, at a third of the speed.
TEST(PairFrontEnd, IsFoundAgainWhereTheWheelSkids) {
  Drive drive{[](double t) { return 2.0 + 0.4 * t; }};
  drive.told_path = [](double t) { return 0.4 * (t - 0.67 * std::max(0.0, t - 20.0)); };
  const Result result = driven(drive);
  const auto begins_in_it = [](const Found& found) { return found.from_s > 20.0; };
  const auto first = std::find_if(result.passages.begin(), result.passages.end(), begins_in_it);
  ASSERT_NE(first, result.passages.end());
  EXPECT_LT(first->to_s, 24.5) << "the next match is looked for after 0.4 m of the told path: 3 s";
  EXPECT_GT(result.last_s, 35.0);
  EXPECT_NEAR(mean(result.passages), 0.0, 0.003);
}

// At 5 cm/s the leading antenna passed 12.4 s ago what the trailing one sees now; after a stop of 4
// s on the way, at 0.4 m/s, some 6 s ago.
TEST(PairFrontEnd, TellsWhenThePassagesBeginThatAreStillToCome) {
  const GprConfig config = two_antennas();
  const auto begin_of = [&](const std::function<double(double)>& place, double now) {
    Travel travel;
    for (double t = 0.0; t <= now; t += 0.2) travel.append({from_seconds(t), place(t), 0.0});
    return PairFrontEnd::begin_of_next(config, travel);
  };
  const double behind = 1.4 * kApart + 0.2;
  const auto steady = begin_of([](double t) { return 0.4 * t; }, 20.0);
  ASSERT_TRUE(steady);
  EXPECT_NEAR(to_seconds(*steady), 20.0 - behind / 0.4, 0.1);
  const auto stopped = [](double t) { return 0.4 * (t - std::clamp(t - 19.0, 0.0, 4.0)); };
  const auto across = begin_of(stopped, 23.6);
  ASSERT_TRUE(across);
  EXPECT_NEAR(to_seconds(*across), 19.6 - behind / 0.4, 0.1);
  EXPECT_FALSE(begin_of([](double t) { return 0.05 * t; }, 50.0)) << "too long ago";
  EXPECT_FALSE(begin_of([](double) { return 1.0; }, 20.0)) << "it has not moved";
  GprConfig one;
  EXPECT_FALSE(PairFrontEnd::begin_of_next(one, Travel({{0, 0.0, 0.0}})));
}

// On whichever ground, with a wheel that is right or not, and in either direction.
TEST(PairFrontEnd, CablesThatAreSwappedAreNoticedAndGiveNoDisplacement) {
  for (const int ground : {1, 2, 3, 4})
    for (const double told : {1.0, 1.3})
      for (const double speed : {0.4, -0.4}) {
        Drive drive{[=](double t) { return (speed > 0 ? 2.0 : 22.0) + speed * t; }, told};
        drive.ground = ground;
        drive.swapped = [](double) { return true; };
        drive.seconds = 20.0;
        const Result result = driven(drive);
        EXPECT_EQ(result.given, 0) << ground << ' ' << told << ' ' << speed;
        EXPECT_EQ(result.state, PairState::kSwapped) << ground << ' ' << told << ' ' << speed;
      }
}

// Accelerations alone run off, as on a drive by `radar_imu`: after 20 s the told speed is twice the
// true one, and 5 sigma from a standstill.
TEST(PairFrontEnd, CablesThatAreSwappedStaySoWhereTheSpeedRunsOff) {
  for (const int ground : {1, 2, 3, 4}) {
    Drive drive{[](double t) { return 2.0 + 0.4 * t; }};
    drive.ground = ground;
    drive.swapped = [](double) { return true; };
    drive.told_path = [](double t) { return 0.4 * t + 0.01 * t * t; };
    drive.sigma_without_wheel = [](double t) { return 0.008 * t; };
    drive.seconds = 120.0;
    const Result result = driven(drive);
    EXPECT_EQ(result.given, 0) << ground;
    EXPECT_EQ(result.state, PairState::kSwapped) << ground;
  }
}

// Without a known direction the antennas may be swapped. What is found meanwhile is held back, and
// counts, at its own time, as soon as it is known that they are not; in a window of 5 s.
TEST(PairFrontEnd, WhatIsFoundBeforeTheOrderIsConfirmedCountsAfterwards) {
  Drive drive{[](double t) { return 2.0 + 0.4 * t; }};
  const Result known = driven(drive);
  drive.speed_known_from = known.first_s + 3.0;
  const Result later = driven(drive);
  EXPECT_GT(later.first_given_s, drive.speed_known_from);
  EXPECT_LT(later.first_s, drive.speed_known_from - 1.0);
  EXPECT_GT(later.first_s, later.first_given_s - 5.0);
  EXPECT_GE(later.given, known.given - 2);
}

TEST(PairFrontEnd, GoesOnAfterSwappedCablesWereExchanged) {
  Drive drive{[](double t) { return 2.0 + 0.4 * t; }};
  drive.swapped = [](double t) { return t < 15.0; };
  drive.seconds = 47.0;
  const Result result = driven(drive);
  EXPECT_EQ(result.state, PairState::kFollows);
  ASSERT_GT(result.passages.size(), 8U);
  EXPECT_NEAR(mean(result.passages), 0.0, 0.002);
}

TEST(PairFrontEnd, NeedsTwoAntennasOneBehindTheOther) {
  GprConfig config;
  EXPECT_FALSE(antenna_row(config));
  config.antennas = {{0, {0.1, 0.2, 0}}, {1, {0.1, -0.2, 0}}};
  EXPECT_FALSE(antenna_row(config)) << "side by side";
  EXPECT_NEAR(antenna_row(two_antennas()).value().distance_m(), kApart, 1e-12);
}

TEST(Travel, ARevisedPathContinuesTheOneBefore) {
  Travel travel;
  for (int i = 0; i <= 10; ++i) travel.append({from_seconds(i), 0.5 * i});
  travel.revise({{from_seconds(8), 100.0}, {from_seconds(9), 101.0}});
  EXPECT_DOUBLE_EQ(travel.at(from_seconds(8)), 4.0);
  EXPECT_DOUBLE_EQ(travel.at(from_seconds(9)), 5.0);
  EXPECT_DOUBLE_EQ(travel.at(from_seconds(12)), 5.0);
}

// In a steady bend the rear antenna follows the front one; over a turn on the spot it does not.
TEST(Run, TellsHowFarAsideAPartPassesThePlaceOfAnother) {
  const Eigen::Vector3d front(0.15, 0, 0), rear(-0.15, 0, 0);
  constexpr double kSpeed = 0.4, kRadius = 1.0;
  for (const double sense : {1.0, -1.0}) {
    const auto path = [sense](const auto& heading) {
      Travel travel;
      for (int i = 0; i <= 100; ++i) {
        const double t = 0.1 * i;
        travel.append({from_seconds(t), sense * kSpeed * t, heading(t)});
      }
      return gpr::Run(travel, from_seconds(10));
    };
    const Eigen::Vector3d &leads = sense > 0 ? front : rear, &follows = sense > 0 ? rear : front;
    const TimeNs from = from_seconds(5), to = from_seconds(5 + 0.3 / kSpeed);
    const gpr::Run straight = path([](double) { return 1.0; });
    EXPECT_NEAR(straight.apart(from, leads, to, follows, 1.0), 0.0, 1e-6);
    EXPECT_NEAR(straight.mirrored().apart(from, leads, to, follows, 1.0), 0.0, 1e-6);
    EXPECT_NEAR(straight.apart(from, leads, to, leads, 1.0), 0.3, 1e-6);
    const gpr::Run bend = path([=](double t) { return sense * kSpeed / kRadius * t; });
    EXPECT_LT(bend.apart(from, leads, to, follows, 1.0), 0.003);
    EXPECT_NEAR(bend.apart(from, leads, to, follows, 1.2), 0.06, 0.003);
    const gpr::Run corner = path([](double t) { return t < 5.05 ? 0.0 : M_PI / 2; });
    EXPECT_GT(corner.apart(from, leads, to, follows, 1.0), 0.1);
  }
}

TEST(Run, EndsWhereTheRobotTurnedBack) {
  Travel travel;
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.25 * i;
    travel.append({from_seconds(t), t < 5 ? t : 10 - t});
  }
  const gpr::Run run(travel, from_seconds(8));
  EXPECT_EQ(run.direction(), -1);
  EXPECT_NEAR(run.length(), 3.0, 0.05);
  EXPECT_NEAR(to_seconds(run.time_at(run.newest() - 1.0)), 7.0, 0.01);
}

}  // namespace
}  // namespace gprodom::gpr
