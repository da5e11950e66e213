// The noise that an IMU shows while the robot drives, also one of few samples a second.
#include <gtest/gtest.h>

#include <random>

#include "motion/motion_judge.h"

namespace gprodom {
namespace {

constexpr ImuNoise kReference{2e-4, 8e-4};

class ImuNoiseTest : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Hz, ImuNoiseTest, testing::Values(25.0, 50.0, 400.0));

TEST_P(ImuNoiseTest, VibrationIsMeasuredAtAnySampleRate) {
  MotionJudge judge{Config()};
  StateResult first;
  first.state.time = from_seconds(100.0);
  judge.begin(first, {first.state, {}, kReference});
  std::mt19937 random(1);
  std::normal_distribution<double> n;
  const double rate = GetParam(), vibration = 5 * std::sqrt(rate);
  double t = 100.0;
  for (; t < 103.0; t += 1 / rate) {
    ImuSample sample{from_seconds(t), {0, 0, 9.80665}, {0, 0, 0}};
    for (int axis = 0; axis < 3; ++axis) {
      sample.acceleration[axis] += vibration * kReference.accel_density * n(random);
      sample.angular_velocity[axis] += vibration * kReference.gyro_density * n(random);
    }
    judge.add(sample);
  }
  const ImuNoise noise = judge.noise(from_seconds(t - 0.3), from_seconds(t));
  EXPECT_NEAR(noise.accel_density / kReference.accel_density, 5.0, 1.5);
  EXPECT_NEAR(noise.gyro_density / kReference.gyro_density, 5.0, 1.5);
}

}  // namespace
}  // namespace gprodom
