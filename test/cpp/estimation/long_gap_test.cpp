// A robot on a circle whose IMU falls silent: what is known again afterwards must stay known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "gprodom/state_estimator.h"

namespace gprodom {
namespace {

constexpr double kStateInterval = 0.2, kSampleInterval = 0.01;  // s
constexpr double kSpeed = 0.5, kTurn = 0.1;                     // m/s, rad/s

// One interval of driving. Silent: what the histories make of an IMU gap, the last values held.
StateInput drive(double from, bool silent, std::mt19937& random) {
  std::normal_distribution<double> noise;
  StateInput input;
  input.time = from_seconds(from + kStateInterval);
  input.noise = {1.6e-4, 6e-4};
  input.has_wheel = true;
  for (int i = 0; i < kStateInterval / kSampleInterval - 0.5; ++i) {
    MotionStep step;
    step.dt = kSampleInterval;
    step.acceleration = Eigen::Vector3d(0, kSpeed * kTurn, 9.80665);
    step.angular_velocity = Eigen::Vector3d(0, 0, kTurn);
    for (int axis = 0; axis < 3; ++axis) {
      step.acceleration[axis] += 6e-3 * noise(random);
      step.angular_velocity[axis] += 1.6e-3 * noise(random);
    }
    step.wheel_m = kSpeed * kSampleInterval;
    step.bridged = silent;
    input.steps.push_back(step);
  }
  return input;
}

TEST(LongGap, TheStateBeyondItHoldsOnceTheWindowHasPassed) {
  const Config config;
  InitialState initial;
  initial.state.time = from_seconds(10.0);
  initial.state.v_odom.x() = kSpeed;
  StateMatrix covariance = 1e-6 * StateMatrix::Identity();
  initial.noise = {1.6e-4, 6e-4};
  initial.prior = gaussian_prior(initial.state, covariance);
  StateEstimator estimator(config, initial);
  std::mt19937 random(1);

  StateResult result, at_return;
  double time = 10.0;
  for (; time < 100.0 - 1e-6; time += kStateInterval) {
    const bool silent = time > 30.0 - 1e-6 && time < 40.0 - 1e-6;
    result = estimator.add(drive(time, silent, random));
    ASSERT_TRUE(result.solve.usable);
    EXPECT_EQ(result.bridged, silent);
    if (time < 41.0) at_return = result;
  }
  // The same way on from where it came back, on the circle.
  const double angle = kTurn * to_seconds(result.state.time - at_return.state.time);
  const double radius = kSpeed / kTurn;
  const Eigen::Vector3d moved =
      at_return.state.q_odom_body.conjugate() * (result.state.p_odom - at_return.state.p_odom);
  EXPECT_LT((moved - radius * Eigen::Vector3d(std::sin(angle), 1 - std::cos(angle), 0)).norm(),
            0.3);
  EXPECT_LT(
      (result.state.q_odom_body.conjugate() * result.state.v_odom - Eigen::Vector3d(kSpeed, 0, 0))
          .norm(),
      0.03);
  // Heading and place are as unknown as the gap left them, tilt and speed are not.
  const auto sigma = [](const StateResult& r, int i) { return std::sqrt(r.covariance(i, i)); };
  EXPECT_GT(sigma(result, row::kTheta + 2), 1.0);
  EXPECT_NEAR(sigma(result, row::kTheta + 2), sigma(at_return, row::kTheta + 2), 0.02);
  EXPECT_LT(sigma(result, row::kTheta), 0.01);
  EXPECT_LT(sigma(result, row::kV), 0.05);
}

}  // namespace
}  // namespace gprodom
