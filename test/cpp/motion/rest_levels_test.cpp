// Levels at rest: measured at the start, or from the quietest second after a start on the move.
#include "motion/rest/rest_levels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gprodom {
namespace {

constexpr ImuNoise kOwn{2e-4, 8e-4};

std::vector<ImuSample> second(double vibration) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  std::vector<ImuSample> samples;
  constexpr int kRate = 200;  // Hz
  const double scale = vibration * std::sqrt(static_cast<double>(kRate));
  for (int i = 0; i < kRate; ++i) {
    ImuSample sample{from_seconds(1.0 * i / kRate), {0, 0, 9.80665}, {0, 0, 0}};
    for (int axis = 0; axis < 3; ++axis) {
      sample.acceleration[axis] += scale * kOwn.accel_density * noise(random);
      sample.angular_velocity[axis] += scale * kOwn.gyro_density * noise(random);
    }
    samples.push_back(sample);
  }
  return samples;
}

double times_own(const RestLevels& rest) { return rest.noise().accel_density / kOwn.accel_density; }

TEST(RestLevels, AfterAStartOnTheMoveTheQuietestSecondCounts) {
  RestLevels rest;
  rest.begin({NavState(), {}, kOwn, true});
  EXPECT_FALSE(rest.known());
  rest.stood(second(10.0), 0.0);  // the body rocks
  EXPECT_TRUE(rest.known());
  EXPECT_NEAR(times_own(rest), 10.0, 1.0);
  rest.stood(second(3.0), 0.011);
  EXPECT_NEAR(times_own(rest), 3.0, 0.3);
  rest.stood(second(5.0), 0.1);
  EXPECT_NEAR(times_own(rest), 3.0, 0.3);
  EXPECT_EQ(rest.wheel_mps(), 0.011);  // the robot sets off: its wheel does not count
  rest.stood(second(0.1), 0.0);
  EXPECT_EQ(times_own(rest), 1.0);  // never below the sensor's own
}

TEST(RestLevels, AStandstillAtTheStartIsKept) {
  RestLevels rest;
  rest.measure(second(2.0), 0.011);
  rest.begin({NavState(), {}, kOwn, false});
  EXPECT_TRUE(rest.known());
  EXPECT_EQ(times_own(rest), 1.0);
  EXPECT_NEAR(rest.vibration().accel_density, 2 * kOwn.accel_density, 0.2 * kOwn.accel_density);
  rest.stood(second(0.5), 0.02);
  EXPECT_EQ(times_own(rest), 1.0);
  EXPECT_EQ(rest.wheel_mps(), 0.011);
}

}  // namespace
}  // namespace gprodom
