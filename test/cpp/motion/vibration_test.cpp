// When the IMU's vibration tells standing from driving, and when it does not.
#include "motion/rest/vibration.h"

#include <gtest/gtest.h>

namespace gprodom {
namespace {

constexpr ImuNoise kRest{2e-4, 8e-4};

ImuNoise times(double factor) {
  return {factor * kRest.gyro_density, factor * kRest.accel_density};
}

Vibration after_driving(const ImuNoise& level) {
  Vibration vibration;
  for (int i = 0; i < 100; ++i) vibration.drives(level);
  return vibration;
}

TEST(Vibration, AnEngineHidesRestAndElectricMotorsDoNot) {
  EXPECT_TRUE(after_driving(times(1.2)).hides_rest(times(1.5), kRest));
  EXPECT_FALSE(after_driving(times(5.0)).hides_rest(times(1.5), kRest));
}

TEST(Vibration, OneSensorThatTellsIsEnough) {
  const Vibration by_accel = after_driving({kRest.gyro_density, 5 * kRest.accel_density});
  EXPECT_FALSE(by_accel.hides_rest(times(1.5), kRest));
  const Vibration by_gyro = after_driving({5 * kRest.gyro_density, kRest.accel_density});
  EXPECT_FALSE(by_gyro.hides_rest(times(1.5), kRest));
}

// Some of the driving is as quiet as a standstill: in the low tenth.
TEST(Vibration, QuietMomentsOfDrivingCount) {
  Vibration vibration;
  for (int i = 0; i < 100; ++i) vibration.drives(times(i % 5 == 0 ? 1.0 : 5.0));
  EXPECT_TRUE(vibration.hides_rest(times(1.5), kRest));
}

TEST(Vibration, BeforeDrivingHasShownItsLevelAnEngineMayVaryByTwo) {
  const Vibration vibration;
  EXPECT_TRUE(vibration.hides_rest(times(1.9), kRest));
  EXPECT_FALSE(vibration.hides_rest(times(2.1), kRest));
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
