#include "motion/slip/slip_belief.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "motion/slip/accelerometer_axes.h"
#include "motion/slipping_drive.h"

namespace gprodom {
namespace {

using Drive = SlippingDrive;

double wavy(double t) { return 0.4 + 0.15 * std::sin(0.6 * t); }
double even(double) { return 0.4; }

constexpr ImuNoise kCart{3e-4, 0.01}, kShaken{3e-3, 0.3};

// The largest slip that is told from one second to another.
double worst_told(Drive& drive, int from, int to, double coherence = 0.0) {
  double worst = 0.0;
  for (int t = from; t <= to; ++t) {
    drive.to(t, coherence);
    worst = std::max(worst, std::abs(drive.told()));
  }
  return worst;
}

// A solver that is too slow, or a gap of the IMU, gives an interval of many seconds.
TEST(SlipBelief, ALongIntervalLeavesItFinite) {
  SlipBelief belief{Config()};
  StateResult newest;
  newest.covariance.diagonal().setConstant(1e-8);
  newest.state.v_odom.x() = 0.6;
  TimeNs now = 0;
  for (int i = 0; i < 60; ++i) {
    const int steps = i == 30 ? 640 : kSteps;
    StateInput input;
    input.has_wheel = true;
    input.steps.assign(steps, {0.01, {0, 0, kGravity}, {0, 0, 0}, 0.006, false, false, {}});
    input.time = now += from_seconds(0.01 * steps);
    input.wheel_sigma_m = 1e-3;
    belief.advance(input, newest, input.noise, 0.0);
  }
  for (const IntervalSlip& slip : belief.recent()) {
    EXPECT_TRUE(std::isfinite(slip.l));
    EXPECT_TRUE(std::isfinite(slip.sigma));
  }
  EXPECT_TRUE(std::isfinite(belief.share().value()));
}

TEST(SlipBelief, AWheelThatGripsIsBelieved) {
  Drive drive(kCart, wavy, zero, zero);
  EXPECT_LT(worst_told(drive, 20, 300, 0.1), 0.03);
  EXPECT_LT(drive.sigma(), 0.03);
}

// The speed of the robot goes up and down by a third: where the wheel's does so by more, it slips;
// in hindsight that is surer.
TEST(SlipBelief, ChangesOfSpeedTellOfSlip) {
  Drive drive(kCart, wavy, zero, [](double t) { return -0.25 * ramp(t, 40, 70); });
  drive.to(39);
  EXPECT_NEAR(drive.told(), 0.0, 0.03);
  drive.to(42.4);
  const double at_once = drive.told();
  drive.to(46.4);
  EXPECT_LT(std::abs(drive.told_of(4.0) + 0.2), std::abs(at_once + 0.2));
  drive.to(60);
  EXPECT_NEAR(drive.told(), -0.25, 0.06);
  drive.to(95);
  EXPECT_NEAR(drive.told(), 0.0, 0.05);
}

// Slips of random size begin and end at random, with an IMU whose error of acceleration lasts for
// seconds, as on real robots: the variance that is left is that of the error, to a factor.
TEST(SlipBelief, WhatIsLeftIsTheSizeOfTheError) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  double squared = 0.0, left = 0.0;
  for (unsigned run = 0; run < 40; ++run) {
    const double begin = 30 + 30 * uniform(engine), end = begin + 10 + 20 * uniform(engine);
    const double size = uniform(engine) < 0.5 ? -0.3 * std::abs(normal(engine)) : 0.0;
    const double phase = 6 * uniform(engine), error = 0.03 * normal(engine);
    Drive drive(kCart, wavy, zero, [=](double t) { return size * ramp(t, begin, end); });
    drive.disturbed = [=](double t) { return error * std::sin(0.9 * t + phase); };
    drive.seed(run);
    for (int t = 20; t <= 100; t += 2) {
      drive.to(t);
      if (!drive.left()) continue;
      squared += std::pow(drive.oldest_error(), 2);
      left += *drive.left();
    }
  }
  EXPECT_GT(squared / left, 0.5);
  EXPECT_LT(squared / left, 2.0);
}

// In a bend the robot is pulled sideways as fast as it is, whatever the wheel says.
TEST(SlipBelief, BendsTellOfSlip) {
  const OfTime slip = [](double t) { return -0.25 * ramp(t, 40, 100); };
  Drive straight(kCart, even, zero, slip);
  Drive bent(
      kCart, even, [](double) { return 0.5; }, slip);
  straight.to(80);
  bent.to(80);
  EXPECT_NEAR(bent.told(), -0.25, 0.05);
  EXPECT_LT(std::abs(bent.told() + 0.25), 0.5 * std::abs(straight.told() + 0.25));
}

// An IMU that says nothing, and ground that tells the way to a tenth a second.
TEST(SlipBelief, CoherenceTellsOfSlip) {
  const OfTime slip = [](double t) { return -0.35 * ramp(t, 60, 120); };
  Drive blind(kShaken, even, zero, slip), seeing(kShaken, even, zero, slip);
  blind.to(80);
  seeing.to(80, 0.1);
  EXPECT_NEAR(blind.told(), 0.0, 0.1);
  EXPECT_NEAR(seeing.told(), -0.35, 0.1);
  seeing.to(160, 0.1);
  EXPECT_NEAR(seeing.told(), 0.0, 0.06);
}

TEST(SlipBelief, AnotherUnitOfCoherenceIsNoSlip) {
  Drive drive(kShaken, even, zero, zero);
  drive.to(60, 0.1);
  drive.change_unit(3.0);
  for (double t = 62; t < 120; t += 2) {
    drive.to(t, 0.1);
    EXPECT_NEAR(drive.told(), 0.0, 0.06) << t;
  }
}

// Noise is known to a factor. A wheel that jitters twice as much as it is said to, beside an IMU
// that shakes half as much, does not slip: errors are no less likely the further the robot is said
// to have come.
TEST(SlipBelief, NoiseThatIsNotKnownIsNoSlip) {
  Drive drive({3e-3, 0.06}, even, zero, zero, 0.5);
  drive.jitter_m = 0.01;
  EXPECT_LT(worst_told(drive, 10, 300), 0.1);
}

// A bias that moves turns what is level, and gravity leaks into the accelerations along the way.
TEST(SlipBelief, AGyroBiasThatMovesIsNoSlip) {
  Drive drive(kCart, wavy, zero, zero);
  drive.bias_moves = {1e-3, 40.0};
  EXPECT_LT(worst_told(drive, 40, 120), 0.06);
}

TEST(SlipBelief, ASharpBendIsNoSlip) {
  const OfTime turn = [](double t) { return 1.2 * ramp(std::fmod(t, 20.0) * 6, 36, 60); };
  Drive drive(kCart, wavy, turn, zero);
  EXPECT_LT(worst_told(drive, 10, 200), 0.03);
}

// In a bend the speed within the second counts. Without the bias in it, a small car that winds its
// way came to slip by a fifth, and drifted by metres.
TEST(SlipBelief, ABiasThatIsKnownIsNoSlipInBends) {
  const OfTime winds = [](double t) { return std::sin(1.5 * t); };
  for (const double bias : {-0.5, 0.5}) {
    Drive drive(
        {3e-4, 0.1}, [](double) { return 1.3; }, winds, zero);
    drive.bias(bias);
    EXPECT_LT(worst_told(drive, 10, 100), 0.03) << bias;
  }
}

// A corner every ten seconds, to the left and to the right.
double corners(double t) {
  return 0.4 * (ramp(std::fmod(t, 20.0) * 3, 6, 21) - ramp(std::fmod(t, 20.0) * 3, 36, 51));
}

// An offset of 0.3 m or less may be that of the IMU.
TEST(SlipBelief, BendsTellWhereTheWheelIs) {
  for (const double y : {-0.6, 0.0, 0.4}) {
    Drive drive(kCart, wavy, corners, zero);
    drive.wheel_y_m = y;
    drive.to(10);
    EXPECT_NEAR(drive.position().learnt().sigma_m, 0.1, 0.1) << y;
    EXPECT_LT(worst_told(drive, 20, 100), 0.05) << y << ": it is taken for slip";
    EXPECT_NEAR(drive.position().learnt().y_m, y, 0.03) << y;
    EXPECT_LT(drive.position().learnt().sigma_m, 0.03) << y;
    EXPECT_NEAR(drive.position().believed_m(), y, 0.03) << y;
  }
}

TEST(SlipBelief, ErrorOfTheWheelsPositionIsAsLargeAsItSays) {
  constexpr int kDrives = 60;
  std::mt19937 engine(7);
  std::normal_distribution<double> prior(0.0, slip::WheelPosition({}).learnt().sigma_m);
  double sum = 0.0;
  for (int i = 0; i < kDrives; ++i) {
    const double y = prior(engine);
    Drive drive({3e-4, 0.05}, wavy, corners, zero);
    drive.seed(static_cast<unsigned>(i));
    drive.wheel_y_m = y;
    drive.to(25);
    const slip::LearntPosition& told = drive.position().learnt();
    sum += std::pow((told.y_m - y) / told.sigma_m, 2);
  }
  EXPECT_GT(sum / kDrives, 0.3);
  EXPECT_LT(sum / kDrives, 1.6);
}

// As a small car measured when it set off into a bend: the noise falls, and what was wrong with the
// accelerations stays wrong for seconds.
TEST(SlipBelief, AccelerationsThatAreWrongInOneBendDoNotMoveTheWheel) {
  const OfTime sets_off = [](double t) { return 0.2 + 1.1 * std::min(1.0, t / 2); };
  const OfTime turn = [](double t) { return 0.8 * ramp(6 * t, 12, 24); };
  const OfTime wrong = [](double t) { return -0.6 * ramp(t, 1.5, 7.5); };
  Drive drive({3e-4, 0.12}, sets_off, turn, zero, 0.3);
  drive.accel_density = [](double t) { return t < 2 ? 0.4 : 0.12; };
  drive.disturbed = wrong;
  double worst_m = 0.0;
  for (int t = 5; t <= 20; ++t) {
    drive.to(t);
    worst_m = std::max(worst_m, std::abs(drive.position().believed_m()));
  }
  EXPECT_LT(worst_m, 0.05);
}

TEST(SlipBelief, AWheelIsWhereItIsConfiguredUntilBendsSayOtherwise) {
  Drive straight(kCart, wavy, zero, zero);
  straight.wheel_y_m = -0.6;
  straight.to(30);
  EXPECT_NEAR(straight.position().believed_m(), 0.0, 0.01);
  Config pair;
  pair.wheel.drive = WheelDrive::kDifferential;
  pair.wheel.lever_arm.y() = 0.1;
  EXPECT_FALSE(slip::WheelPosition(pair.wheel).learns());
  EXPECT_EQ(slip::WheelPosition(pair.wheel).believed_m(), 0.1);
  // Of an earlier run: that it is elsewhere is kept.
  slip::WheelPosition position{WheelConfig()};
  position.resume({-0.6, 0.1});
  EXPECT_NEAR(position.believed_m(), -0.6, 0.01);
  // A tape is some centimetres off.
  slip::WheelPosition measured{WheelConfig()};
  measured.resume({0.06, 0.005});
  EXPECT_NEAR(measured.believed_m(), 0.0, 0.01);
  // As a Kobuki showed, whose wheels are where they are configured: its IMU is aside.
  slip::WheelPosition imu_aside{WheelConfig()};
  imu_aside.resume({0.16, 0.034});
  EXPECT_NEAR(imu_aside.believed_m(), 0.0, 0.02);
  position.resume({-0.6, 2.0});  // less than is known anyway
  EXPECT_NEAR(position.learnt().sigma_m, 0.1, 0.01);
}

// Nothing shows the jump with which this slip begins, but that of its end does.
TEST(SlipBelief, ASlipMayBeginWhileTheImuIsSilent) {
  const auto slips = [](double t) { return t > 40.1 && t < 45.1 ? 0.5 : 0.0; };
  Drive drive(kCart, wavy, zero, slips);
  drive.silence = {40.0, 40.2};
  drive.to(48, 0.1);
  EXPECT_GT(drive.told_of(4.0), 0.2);
  EXPECT_NEAR(drive.told(), 0.0, 0.03);
}

// What was known of slip and ground before the IMU was silent holds after it.
TEST(SlipBelief, ASlipOutlastsAGap) {
  Drive drive(kCart, wavy, zero, [](double t) { return -0.25 * ramp(t, 40, 90); });
  drive.silence = {60.0, 60.2};
  drive.to(60, 0.1);
  const double before = drive.told();
  drive.to(61.4, 0.1);
  EXPECT_NEAR(drive.told(), before, 0.1);
  Drive grips(kCart, wavy, zero, zero);
  grips.silence = {60.0, 60.2};
  grips.to(62, 0.1);
  EXPECT_NEAR(grips.told(), 0.0, 0.03);
}

TEST(SlipBelief, AWheelThatNeverSlipsOrIsNotThereIsNotAskedAbout) {
  Config config;
  config.wheel.slip_share = 0.0;
  SlipBelief belief(config);
  StateInput input;
  input.time = 1;
  belief.advance(input, StateResult(), {2e-4, 8e-4}, 0.0);
  EXPECT_TRUE(belief.recent().empty());
}

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
