#include "motion/slip/accelerometer_axes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "motion/slipping_drive.h"

namespace gprodom {
namespace {

// An acceleration by such an IMU, while the wheel grips, looks like slip if no hypothesis is that
// the axes are others. A slip is still found afterwards.
TEST(AccelerometerAxes, AnImuThatIsTurnedOrMirroredIsNoSlip) {
  struct Mount {
    double yaw;
    bool mirrored;
  };
  const auto speed = [](double t) { return 0.1 + 0.7 * ramp(std::fmod(t, 20), 2, 16); };
  const auto turn = [](double t) { return 0.3 * std::sin(0.2 * t); };
  const auto slip = [](double t) { return -0.4 * ramp(t, 104, 130); };
  for (const Mount& mount : {Mount{0.5, false}, Mount{M_PI / 2, false}, Mount{-2.0, false},
                             Mount{M_PI, false}, Mount{0, true}}) {
    SCOPED_TRACE(mount.yaw);
    SlippingDrive drive({2e-4, 5e-3}, speed, turn, slip);
    drive.mount(mount.yaw, mount.mirrored);
    double most = 0.0;
    for (double t = 2; t < 100; t += 1) {
      drive.to(t);
      most = std::max(most, std::abs(drive.told()));
    }
    EXPECT_LT(most, 0.15);  // for a moment, in the first acceleration
    EXPECT_LT(std::abs(drive.told()), 0.05);
    // That which is wrong of 1 m/s^2: the chord between both directions.
    const double chord = mount.mirrored ? 2.0 : 2 * std::abs(std::sin(mount.yaw / 2));
    EXPECT_NEAR(drive.axes_error(), chord, 0.15);
    drive.to(120);
    EXPECT_LT(drive.told(), -0.2);
  }
}

// For so long that the weight of the other hypotheses can no longer be told from 0.
TEST(AccelerometerAxes, AnImuThatIsMountedAsConfiguredHasNoErrorOfItsAxes) {
  SlippingDrive drive(
      {2e-4, 5e-3}, [](double t) { return 0.1 + 0.7 * ramp(std::fmod(t, 20), 2, 16); },
      [](double t) { return 0.3 * std::sin(0.2 * t); }, zero);
  EXPECT_LT(drive.axes_error(), 0.01);
  drive.to(1500);
  EXPECT_LT(drive.axes_error(), 1e-4);  // false if it is not finite
}

// Axes that shrink explain noise better and better: after an hour they were believed, and a third
// of the wheel's distance was taken for slip from then on.
TEST(AccelerometerAxes, AnHourOfVibrationDoesNotMakeOtherAxesLikely) {
  SlippingDrive drive(
      {6e-4, 0.06}, [](double t) { return 0.1 + 1.9 * ramp(std::fmod(t, 200), 2, 196); },
      [](double t) { return 0.1 * std::sin(0.1 * t); }, zero);
  drive.seed(1);
  drive.to(4500);
  EXPECT_LT(drive.axes_error(), 1e-3);
}

}  // namespace
}  // namespace gprodom
