#include "motion/slip_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "motion/watched_drive.h"
#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kSpeed = WatchedDrive::kSpeed;
using Drive = WatchedDrive;

TEST(SlipWatch, DetectsSlipWithItsTimeAndSign) {
  for (const double direction : {1.0, -1.0}) {
    for (const double slipping : {0.5, 1.7}) {
      Drive drive = Drive::alone();
      drive.scale = 1.03;
      drive.published = direction * kSpeed;
      const auto slip = slipping > 1 ? WheelSlip::kFast : WheelSlip::kSlow;
      for (int i = 0; i < 2000; ++i) {
        const double t = 0.005 * i;
        drive.wheel_speed = direction * kSpeed * (t > 4 && t < 6 ? slipping : 1.0);
        drive.run(0.005);
        const WheelSlip now = drive.watch.now();
        const bool may = t > 4 && t<6.35, must = t> 4.3 && t < 6;
        EXPECT_TRUE(now == slip ? may : now == WheelSlip::kNone && !must) << t;
      }
    }
  }
}

TEST(SlipWatch, ErrorWithinTheVelocitysDeviationIsNoSlip) {
  Drive drive = Drive::alone();
  drive.published = kSpeed + 3 * drive.sigma;
  for (int i = 0; i < 2000; ++i) {
    drive.run(0.005);
    ASSERT_EQ(drive.watch.now(), WheelSlip::kNone) << i;
  }
}

TEST(SlipWatch, RemembersIntervalsWithSlip) {
  Drive drive = Drive::alone();
  drive.published = 0.0;
  drive.sigma = 1e-3;
  for (const auto& [wheel_speed, seconds] : {std::pair(0.0, 1.0), {0.5, 0.6}, {0.0, 1.4}}) {
    drive.wheel_speed = wheel_speed;  // spins while it stands
    drive.run(seconds);
  }
  EXPECT_FALSE(drive.slipped(0.2, 0.4));
  EXPECT_TRUE(drive.slipped(1.0, 1.2));
  EXPECT_TRUE(drive.slipped(1.4, 1.6));
  EXPECT_FALSE(drive.slipped(2.0, 2.2));
}

// The velocity was learnt during an undetected slip, and the radar has confirmed the wheel.
Drive misled(bool asked) {
  Drive drive;
  drive.run(3.0);
  drive.published = 0.75;
  drive.asked = asked;
  drive.run(4.0);
  return drive;
}

// The velocity was learnt during an undetected slip. At its end the wheel is right and seems to
// slip.
TEST(SlipWatch, TheRadarDecidesBetweenTheWheelAndThePublishedSpeed) {
  Drive drive = misled(true);
  ASSERT_TRUE(drive.correction);
  EXPECT_NEAR(drive.correction->speed, kSpeed, 0.01);
  EXPECT_LT(drive.correction->ahead_m, -0.5);
  EXPECT_GT(drive.correction->ahead_m, -1.4);
  EXPECT_EQ(drive.watch.now(), WheelSlip::kSlow);  // until the caller corrects the speed
  drive.published = kSpeed;
  drive.run(1.0);
  EXPECT_EQ(drive.watch.now(), WheelSlip::kNone);

  Drive silent_radar;
  silent_radar.radar_speaks = false;
  silent_radar.run(3.0);
  silent_radar.published = 0.75;
  silent_radar.run(4.0);
  EXPECT_FALSE(silent_radar.correction);
}

// A jump of the wheel's speed by half, within what left and right wheels have shown of their noise,
// and beyond it.
TEST(SlipWatch, NoiseOfTheWheelIsNoSlip) {
  for (const double noise : {0.0, 0.1}) {
    Drive drive;
    drive.watch.set_wheel_error({noise, 0.0, WheelConfig{}.noise_floor, 0.0});
    drive.run(3.0);
    drive.wheel_speed = 1.5 * kSpeed;
    drive.run(0.5);
    EXPECT_EQ(drive.watch.now() == WheelSlip::kNone, noise > 0) << noise;
  }
}

// A robot that rocks: the accelerations are wrong by more than the velocity's deviation says, now
// and then by ten times as much. That is no slip, and a slip is still found.
TEST(SlipWatch, ARobotWhoseImuIsOftenWrongNeedsMoreEvidence) {
  Noise normal(1);
  Drive drive;
  drive.radar_speaks = false;
  int slips = 0;
  for (int i = 0; i < 600; ++i) {
    const double z = normal();
    drive.published = kSpeed + 1.5 * drive.sigma * z * std::abs(z);
    drive.run(0.3);
    if (i >= 100) slips += drive.watch.now() != WheelSlip::kNone;
  }
  EXPECT_LE(slips, 1);
  drive.published = kSpeed;
  drive.run(1.0);
  ASSERT_EQ(drive.watch.now(), WheelSlip::kNone);
  drive.wheel_speed = 3 * kSpeed;
  drive.run(0.4);
  EXPECT_EQ(drive.watch.now(), WheelSlip::kFast);
}

// It falls as the wheel falls silent. What it says of the speed is wrong by the time the wheel is
// back.
TEST(SlipWatch, DecisionThatCannotBeUsedAtOnceIsDropped) {
  for (const double silence : {3.0, 12.0}) {
    Drive drive = misled(false);
    drive.wheel_speaks = drive.radar_speaks = false;
    drive.run(0.3);
    drive.asked = true;
    drive.run(silence);
    drive.wheel_speaks = true;
    drive.published = kSpeed;
    drive.run(1.0);
    EXPECT_FALSE(drive.correction) << silence;
  }
}

// After a gap of the IMU the published speed is the wheel's.
TEST(SlipWatch, RadarJudgesTheWheelWhileTheSpeedIsUnknown) {
  for (const double direction : {1.0, -1.0}) {
    Drive drive;
    drive.speed_known = false;
    drive.ground = direction * kSpeed;
    drive.wheel_speed = drive.published = 1.8 * direction * kSpeed;
    drive.run(4.0);
    ASSERT_TRUE(drive.correction);
    EXPECT_NEAR(drive.correction->speed, direction * kSpeed, 0.01);
    EXPECT_NEAR(drive.correction->sigma, 0.2 * kSpeed, 0.01);
    EXPECT_LT(direction * drive.correction->ahead_m, -0.25);  // of 0.3 to 0.6 m
    EXPECT_GT(direction * drive.correction->ahead_m, -0.65);
    EXPECT_TRUE(drive.contradicted());
    EXPECT_EQ(drive.watch.now(), WheelSlip::kFast);

    drive.wheel_speed = drive.published = direction * kSpeed;
    drive.run(3.0);
    EXPECT_FALSE(drive.contradicted());
    EXPECT_EQ(drive.watch.now(), WheelSlip::kNone);
  }
  Drive agreed;
  agreed.speed_known = false;
  agreed.run(4.0);
  EXPECT_FALSE(agreed.correction);
  EXPECT_FALSE(agreed.contradicted());
}

TEST(SlipWatch, TheRadarSeesTheEndOfASlipWhileTheSpeedIsUnknown) {
  Drive drive;
  drive.speed_known = false;
  drive.published = 0.4 * kSpeed;
  drive.run(3.0);
  ASSERT_TRUE(drive.correction);
  EXPECT_NEAR(drive.correction->speed, kSpeed, 0.01);
  EXPECT_DOUBLE_EQ(drive.correction->sigma, 0.1);
  EXPECT_FALSE(drive.contradicted());
  Drive slips;  // as far as can be known
  slips.speed_known = slips.radar_speaks = false;
  slips.wheel_speed = 1.8 * kSpeed;
  slips.run(3.0);
  EXPECT_FALSE(slips.correction);
}

// The speed published before the gap is no longer evidence.
TEST(SlipWatch, DecisionBeforeTheSpeedWasLostIsForgotten) {
  Drive drive = misled(false);
  EXPECT_TRUE(drive.contradicted());
  drive.asked = true;
  drive.speed_known = false;
  drive.published = kSpeed;
  drive.radar_speaks = false;
  drive.run(0.01);
  EXPECT_FALSE(drive.contradicted());
  drive.run(1.0);
  EXPECT_FALSE(drive.correction);
}

TEST(SlipWatch, RealSlipIsNotRevoked) {
  for (const double wheel_speed : {0.0, 0.2, 0.55, 0.8}) {
    Drive drive;
    drive.run(3.0);
    drive.wheel_speed = wheel_speed;
    drive.run(6.0);
    EXPECT_FALSE(drive.correction) << wheel_speed;
    EXPECT_NE(drive.watch.now(), WheelSlip::kNone) << wheel_speed;
  }
}

TEST(SlipWatch, WheelThatReturnsInMidSlipMustFirstAgree) {
  Drive drive;
  drive.run(3.0);
  drive.wheel_speaks = false;
  drive.sigma = 0.06;
  drive.wheel_speed = 0.68;  // 4.7 deviations off
  drive.run(5.0);
  drive.wheel_speaks = true;
  drive.run(0.15);
  EXPECT_TRUE(drive.contradicted());
  drive.run(1.0);
  EXPECT_TRUE(drive.contradicted());
  drive.wheel_speed = kSpeed;
  drive.run(1.0);
  EXPECT_FALSE(drive.contradicted());
}

// The velocity of a long slip is less and less certain. That alone does not make the wheel right:
// it would be believed in mid-slip, and its return to the ground's speed be taken for the next
// slip.
TEST(SlipWatch, SlipGoesOnUntilTheWheelAgrees) {
  const double slipping = 0.5 * kSpeed, off = kSpeed - slipping;
  Drive robot = Drive::alone();
  robot.run(2);
  EXPECT_FALSE(robot.contradicted());
  robot.wheel_speed = slipping;
  robot.run(1);
  EXPECT_TRUE(robot.contradicted());
  robot.sigma = off / 4;
  robot.run(1);
  EXPECT_TRUE(robot.contradicted());
  robot.sigma = off / 1.5;  // any wheel agrees
  robot.run(1);
  EXPECT_TRUE(robot.contradicted());
  robot.run(3);  // longer than the window
  EXPECT_FALSE(robot.contradicted());

  Drive fades = Drive::alone();  // without a jump
  fades.run(2);
  fades.wheel_speed = slipping;
  fades.run(1);
  for (; fades.wheel_speed < kSpeed - 1e-9; fades.wheel_speed += 0.01 * kSpeed) fades.run(0.05);
  EXPECT_FALSE(fades.contradicted());

  Drive unsure = Drive::alone();  // as far off, but never seen to begin
  unsure.wheel_speed = slipping;
  unsure.sigma = off / 4;
  unsure.run(2);
  EXPECT_FALSE(unsure.contradicted());
}

// A robot whose wheel has slipped for a second, at this speed.
Drive slipping_at(double wheel_speed) {
  Drive robot = Drive::alone();
  robot.sigma = 0.02;
  robot.run(2);
  robot.wheel_speed = wheel_speed;
  robot.run(1);
  EXPECT_TRUE(robot.contradicted());
  return robot;
}

// The velocity drifts in a slip, and may be more than two standard deviations off at its end. The
// end is seen all the same, since the wheel jumps towards the velocity.
TEST(SlipWatch, JumpBackEndsASlip) {
  Drive robot = slipping_at(0.5 * kSpeed);
  robot.wheel_speed = kSpeed - 3 * robot.sigma;
  robot.run(1);
  EXPECT_FALSE(robot.contradicted());
}

// A velocity that accelerations with a wrong tilt carry towards the slipping wheel's. That is no
// end of the slip: the wheel would be believed in mid-slip.
TEST(SlipWatch, VelocityThatDriftsTowardsTheWheelEndsNoSlip) {
  Drive robot = slipping_at(1.6 * kSpeed);
  const double beyond = 3 * robot.sigma;  // within the threshold of the onset
  while (robot.published < robot.wheel_speed - beyond) {
    robot.published += 0.01 * kSpeed;  // 0.1 of it in a second
    robot.run(0.1);
  }
  EXPECT_TRUE(robot.contradicted());
}

}  // namespace
}  // namespace gprodom
