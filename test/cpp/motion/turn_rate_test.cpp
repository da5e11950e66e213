#include "motion/turn_rate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kStep_s = 0.2;

// An Ornstein-Uhlenbeck process, one value every kStep_s.
std::vector<double> rates(int count, double sigma, double correlation_s, unsigned seed,
                          double mean = 0.0) {
  Noise normal(seed);
  const double stays = std::exp(-kStep_s / correlation_s);
  std::vector<double> result{sigma * normal()};
  while (static_cast<int>(result.size()) < count)
    result.push_back(stays * result.back() + sigma * std::sqrt(1 - stays * stays) * normal());
  for (double& rate : result) rate += mean;
  return result;
}

// From the k-th value over so many steps.
double turned(const std::vector<double>& rates, size_t k, int steps) {
  double sum = 0.0;
  for (size_t i = k; i < k + steps; ++i) sum += 0.5 * (rates[i] + rates[i + 1]) * kStep_s;
  return sum;
}

TurnRate learnt(double sigma, double correlation_s, double mean = 0.0, unsigned seed = 1) {
  TurnRate turn_rate;
  const auto seen = rates(3000, sigma, correlation_s, seed, mean);  // ten minutes
  for (size_t i = 0; i < seen.size(); ++i)
    turn_rate.learn(seen[i], from_seconds(kStep_s * static_cast<double>(i)));
  return turn_rate;
}

// On robots that turn in other ways and in gaps of other lengths: the turn has no bias, its error
// is as large as told, and smaller than that of a turn rate that is kept for two seconds.
TEST(TurnRate, TheErrorOfTheTurnIsAsLargeAsToldAndSmallerThanOfAKeptRate) {
  for (const double correlation_s : {0.7, 2.0, 5.0}) {
    for (const int steps : {5, 15, 50}) {
      const TurnRate turn_rate = learnt(0.6, correlation_s);
      const double gap_s = steps * kStep_s;
      double square = 0.0, kept_square = 0.0;
      int gaps = 0;
      const auto truth = rates(40000, 0.6, correlation_s, 2);
      for (size_t at = 0; at + steps < truth.size(); at += steps, ++gaps) {
        const double by = turned(truth, at, steps);
        const double error = turn_rate.turn(gap_s, {truth[at], truth[at + steps]}, 0.0, gap_s) - by;
        square += error * error;
        kept_square += std::pow(truth[at] * std::min(gap_s, 2.0) - by, 2);
      }
      EXPECT_NEAR(square / gaps / turn_rate.variance(gap_s), 1.0, 0.35)
          << correlation_s << " s, gap " << gap_s << " s";
      EXPECT_LT(square, kept_square) << correlation_s << " s, gap " << gap_s << " s";
    }
  }
}

// A robot on laps: the mean turn rate goes on in the gap, and its own error is part of the
// variance.
TEST(TurnRate, GoesOnTurningToTheSideOfTheLaps) {
  constexpr int kSteps = 100;
  constexpr double kMean = 0.4, kSigma = 0.6, kCorrelation_s = 2.0, kGap_s = kSteps * kStep_s;
  double square = 0.0, variance = 0.0, by_chance = 0.0;
  constexpr int kDrives = 300;
  for (unsigned seed = 0; seed < kDrives; ++seed) {
    const TurnRate laps = learnt(kSigma, kCorrelation_s, kMean, 2 * seed);
    const TurnRate none = learnt(kSigma, kCorrelation_s, 0.0, 2 * seed);
    const auto truth = rates(kSteps + 1, kSigma, kCorrelation_s, 2 * seed + 1, kMean);
    const double told = laps.turn(kGap_s, {truth.front(), truth.back()}, 0.0, kGap_s);
    square += std::pow(told - turned(truth, 0, kSteps), 2);
    variance += laps.variance(kGap_s);
    by_chance += std::abs(none.turn(kGap_s, {0.0, 0.0}, 0.0, kGap_s));
  }
  EXPECT_NEAR(square / variance, 1.0, 0.25);
  // With the mean taken for zero it would be 8 rad.
  EXPECT_LT(std::sqrt(square / kDrives), 5.6);
  EXPECT_LT(by_chance / kDrives, 0.1 * kMean * kGap_s) << "robots without laps";
}

TEST(TurnRate, PartsOfAGapAddUp) {
  const TurnRate turn_rate;
  double sum = 0.0;
  for (int i = 0; i < 10; ++i) sum += turn_rate.turn(4.0, {0.5, -0.2}, 0.4 * i, 0.4 * (i + 1));
  EXPECT_NEAR(sum, turn_rate.turn(4.0, {0.5, -0.2}, 0.0, 4.0), 1e-12);
  // A short gap: the mean of both ends.
  EXPECT_NEAR(turn_rate.turn(0.2, {0.5, -0.2}, 0.0, 0.2), 0.03, 1e-4);
}

// A gap of five seconds between two turns: each step has its part, and the variance is that of all.
TEST(TurnRate, CompletesTheStepsOfAGap) {
  constexpr double kGap_s = 5.0;
  const Eigen::Vector3d bias(0, 0, 0.1), level(0, 0, 9.8);
  ImuHistory imu;
  for (int i = 0; i <= 10; ++i) {
    const TimeNs before = from_seconds(0.01 * i), after = from_seconds(kGap_s + 0.1 + 0.01 * i);
    imu.insert({before, level, {0, 0, 0.6}});
    imu.insert({after, level, {0, 0, -0.1}});
  }
  TurnRate turn_rate;
  double turned = 0.0, variance = 0.0;
  for (double from = 0.0; from < kGap_s + 0.1 - 1e-9; from += kStep_s) {
    StateInput input;
    input.time = from_seconds(from + kStep_s);
    input.steps = imu.steps(from_seconds(from), input.time);
    turn_rate.complete(input, from_seconds(from), bias, imu, 0.0);
    for (const MotionStep& step : input.steps) turned += step.gap_turn.value_or(0.0);
    variance += input.turn_variance;
  }
  EXPECT_NEAR(turned, turn_rate.turn(kGap_s, {0.5, -0.2}, 0.0, kGap_s), 1e-3);
  EXPECT_NEAR(variance, turn_rate.variance(kGap_s), 1e-3);
}

// After laps, in the middle of a long gap: the mean goes on as far as the wheel tells more than it
// does at rest.
TEST(TurnRate, TheLapsGoOnWhileTheWheelTurns) {
  constexpr double kMean = 0.4, kGap_s = 60.0, kFrom_s = 30.0, kResting_m = 0.01;
  const Eigen::Vector3d level(0, 0, 9.8);
  ImuHistory imu;
  for (const double time : {-0.01, 0.0, kGap_s}) imu.insert({from_seconds(time), level, {0, 0, 0}});
  TurnRate laps = learnt(0.1, 1.0, kMean);
  const auto turned = [&](double rolled_m, bool has_wheel = true) {
    StateInput input;
    input.time = from_seconds(kFrom_s + kStep_s);
    input.steps = imu.steps(from_seconds(kFrom_s), input.time);
    input.has_wheel = has_wheel;
    input.steps.front().wheel_m = rolled_m;
    laps.complete(input, from_seconds(kFrom_s), {0, 0, 0}, imu, kResting_m);
    double sum = 0.0;
    for (const MotionStep& step : input.steps) sum += step.gap_turn.value();
    return sum;
  };
  const double as_before = turned(0.0, false);
  EXPECT_NEAR(as_before, kMean * kStep_s, 0.1 * kMean * kStep_s) << "no wheel tells";
  EXPECT_NEAR(turned(100 * kResting_m), as_before, 1e-3 * as_before);
  EXPECT_NEAR(turned(-kResting_m), 0.5 * as_before, 1e-6);
  EXPECT_NEAR(turned(0.0), 0.0, 1e-6);
}

}  // namespace
}  // namespace gprodom
