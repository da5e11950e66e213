// Levels at rest: measured at the start, or from the quietest second after a start on the move.
#include "motion/rest/rest_levels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/rest/imu_noise.h"
#include "motion/rest/vibration.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr ImuNoise kOwn{2e-4, 8e-4};

std::vector<ImuSample> second(double vibration, int rate = 200) {  // Hz
  Noise noise(1);
  std::vector<ImuSample> samples;
  const double scale = vibration * std::sqrt(static_cast<double>(rate));
  for (int i = 0; i < rate; ++i) {
    ImuSample sample{from_seconds(1.0 * i / rate), {0, 0, 9.80665}, {0, 0, 0}};
    noise.shake(sample, scale * kOwn.accel_density, scale * kOwn.gyro_density);
    samples.push_back(sample);
  }
  return samples;
}

double times_own(const RestLevels& rest) { return rest.noise().accel_density / kOwn.accel_density; }

TEST(ImuNoise, IsADensityAtAnySampleRate) {
  for (const int rate : {25, 400}) {
    const ImuNoise noise = measured_noise(second(5.0, rate));
    EXPECT_NEAR(noise.accel_density / kOwn.accel_density, 5.0, 1.5) << rate;
    EXPECT_NEAR(noise.gyro_density / kOwn.gyro_density, 5.0, 1.5) << rate;
  }
}

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

// When the IMU's vibration tells standing from driving, and when it does not.
ImuNoise times(double factor) { return {factor * kOwn.gyro_density, factor * kOwn.accel_density}; }

Vibration after_driving(const ImuNoise& level) {
  Vibration vibration;
  for (int i = 0; i < 100; ++i) vibration.drives(level);
  return vibration;
}

TEST(Vibration, AnEngineHidesRestAndElectricMotorsDoNot) {
  EXPECT_TRUE(after_driving(times(1.2)).hides_rest(times(1.5), kOwn));
  EXPECT_FALSE(after_driving(times(5.0)).hides_rest(times(1.5), kOwn));
}

TEST(Vibration, OneSensorThatTellsIsEnough) {
  const Vibration by_accel = after_driving({kOwn.gyro_density, 5 * kOwn.accel_density});
  EXPECT_FALSE(by_accel.hides_rest(times(1.5), kOwn));
  const Vibration by_gyro = after_driving({5 * kOwn.gyro_density, kOwn.accel_density});
  EXPECT_FALSE(by_gyro.hides_rest(times(1.5), kOwn));
}

// Some of the driving is as quiet as a standstill: in the low tenth.
TEST(Vibration, QuietMomentsOfDrivingCount) {
  Vibration vibration;
  for (int i = 0; i < 100; ++i) vibration.drives(times(i % 5 == 0 ? 1.0 : 5.0));
  EXPECT_TRUE(vibration.hides_rest(times(1.5), kOwn));
}

TEST(Vibration, BeforeDrivingHasShownItsLevelAnEngineMayVaryByTwo) {
  const Vibration vibration;
  EXPECT_TRUE(vibration.hides_rest(times(1.9), kOwn));
  EXPECT_FALSE(vibration.hides_rest(times(2.1), kOwn));
}

TEST(Vibration, FarBelowDrivingIsLessThanHalfOfIt) {
  EXPECT_FALSE(Vibration().far_below_driving(times(0.1)));
  EXPECT_TRUE(after_driving(times(5.0)).far_below_driving(times(2.0)));
  EXPECT_FALSE(after_driving(times(5.0)).far_below_driving(times(3.0)));
}

TEST(Vibration, WithoutAnEarlierStandstillItTellsNothing) {
  EXPECT_TRUE(after_driving(times(5.0)).hides_rest(times(1.5), std::nullopt));
}

}  // namespace
}  // namespace gprodom
