// Every rate of the IMU with every rate of states: adding data never throws, every state is solved
// for, and what is published follows the robot.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "gprodom/odometry.h"
#include "pipeline/test_drive.h"
#include "support/sanitized.h"
#include "support/told.h"

namespace gprodom {
namespace {

constexpr double kStands = 3.0, kDrives = 5.0;  // s
constexpr double kSpeed = 0.5, kRamp = 1.0;     // m/s, s

// How far the robot has driven after it has stood: speed rises over kRamp, then it is constant.
double way(double t) {
  const double since = std::max(0.0, t - kStands);
  return since < kRamp ? 0.5 * kSpeed / kRamp * since * since : kSpeed * (since - 0.5 * kRamp);
}

// phase: of the IMU's period, by which its stamps miss the multiples of it, where states may lie.
std::vector<Input> drive(double imu_hz, double phase) {
  std::vector<Input> samples;
  const auto period = from_seconds(1 / imu_hz);
  for (int i = 0; i * to_seconds(period) < kStands + kDrives; ++i) {
    const auto late = static_cast<TimeNs>(phase * static_cast<double>(period));
    ImuSample imu = resting_imu(kDriveStart + i * period + late, i);
    const double t = to_seconds(imu.time - kDriveStart);
    if (t > kStands && t < kStands + kRamp) imu.acceleration.x() += kSpeed / kRamp;
    samples.emplace_back(imu);
  }
  for (double t = 0.0; t < kStands + kDrives; t += 0.02)
    samples.emplace_back(WheelSample{kDriveStart + from_seconds(t), way(t)});
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Input& a, const Input& b) { return time_of(a) < time_of(b); });
  return samples;
}

Config config_with(double state_hz, SolverKind solver) {
  Config config = default_config();
  config.gpr.enabled = false;
  config.smoother.state_rate = state_hz;
  config.smoother.latency = std::min(config.smoother.latency, 0.5 / state_hz);
  config.smoother.lag = std::max(1.0, 2 / state_hz);  // s, so that the window is solved quickly
  config.smoother.solver = solver;
  return config;
}

void expect_to_follow(double imu_hz, double state_hz, double phase, SolverKind solver) {
  SCOPED_TRACE("IMU at " + std::to_string(imu_hz) + " Hz, states at " + std::to_string(state_hz) +
               " Hz, phase " + std::to_string(phase));
  Odometry odometry(config_with(state_hz, solver));
  OdometryEstimate newest;
  const auto take = [&](const Outputs& outputs) {
    for (const OdometryEstimate& estimate : outputs.odometry) {
      newest = estimate;
      ASSERT_TRUE(estimate.p_odom_body.allFinite() && estimate.pose_covariance.allFinite());
    }
    ASSERT_EQ(count_with(reasons_in(outputs), "solve failed"), 0);
  };
  try {
    for (const Input& sample : drive(imu_hz, phase)) {
      give(odometry, sample);
      take(odometry.step());
    }
    take(odometry.finish());
  } catch (const std::exception& error) {
    FAIL() << "adding data has thrown: " << error.what();
  }
  if (imu_hz < 8) return;  // it goes on, and publishes when it can
  ASSERT_GT(newest.time, kDriveStart + from_seconds(kStands + 0.5 * kDrives));
  const double driven = way(to_seconds(newest.time - kDriveStart));
  EXPECT_NEAR(newest.p_odom_body.x(), driven, 0.1 * driven);
}

constexpr double kImuRates[] = {5,  8,  10,  12.5, 16,  20,  25,  33,  40,
                                50, 62, 100, 125,  200, 250, 400, 500, 1000};   // Hz
constexpr double kStateRates[] = {0.5, 1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50};  // Hz

// One test for each rate of the IMU, so that they run side by side.
class Rates : public testing::TestWithParam<double> {};

TEST_P(Rates, EveryCombinationIsSolved) {
  const double imu_hz = GetParam();
  for (const double state_hz : kStateRates) {
    // Under a sanitizer, forty times slower, only intervals of few samples, where the code has
    // branches of its own, and of each IMU the highest rate of states.
    const bool many = imu_hz > 3 * state_hz && state_hz < std::end(kStateRates)[-1];
    if (GPRODOM_SANITIZED && many) continue;
    for (const double phase : {0.0, 0.37}) {
      expect_to_follow(imu_hz, state_hz, phase, SolverKind::kChain);
      if (HasFatalFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfTheImu, Rates, testing::ValuesIn(kImuRates));

TEST(TwoRates, AreSolvedByTheOtherSolverToo) {
  for (const auto& [imu_hz, state_hz] : {std::pair(20.0, 50.0), {50.0, 50.0}, {10.0, 25.0}})
    expect_to_follow(imu_hz, state_hz, 0.0, SolverKind::kCeres);
}

}  // namespace
}  // namespace gprodom
