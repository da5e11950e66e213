// What the judge answers for a state interval, from what IMU, wheel and radar say together.
#include "motion/motion_judge.h"

#include <gtest/gtest.h>

#include "motion/judged_robot.h"
#include "motion/radar_finding.h"

namespace gprodom {
namespace {

TEST(MotionJudge, AnswersForTheWholeInterval) {
  Robot robot({}, kSpeed);
  robot.vibration = 3.0;
  robot.drive(5);
  const StateInput input = robot.next();
  EXPECT_EQ(input.time, from_seconds(robot.now()));
  double seconds = 0;
  for (const MotionStep& step : input.steps) {
    seconds += step.dt;
    EXPECT_FALSE(step.bridged);
  }
  EXPECT_NEAR(seconds, to_seconds(kInterval), 1e-9);
  EXPECT_NEAR(rolled_m(input), kSpeed * to_seconds(kInterval), 1e-9);
  EXPECT_TRUE(input.has_wheel);
  EXPECT_FALSE(input.standing);
  EXPECT_FALSE(input.wheel_contradicted);
  EXPECT_FALSE(input.speed_correction);
  EXPECT_FALSE(input.gyro_bias);
  EXPECT_TRUE(input.displacements.empty());
}

TEST(MotionJudge, TheNoiseIsThatOfTheIntervalAndNeverLessThanAtStandstill) {
  for (const double vibration : {0.3, 4.0}) {
    Robot robot;
    robot.vibration = vibration;
    const ImuNoise noise = robot.drive(5).noise;
    const double expected = std::max(1.0, vibration);
    EXPECT_NEAR(noise.gyro_density / kReference.gyro_density, expected, 0.2 * expected);
    EXPECT_NEAR(noise.accel_density / kReference.accel_density, expected, 0.2 * expected);
  }
  EXPECT_EQ(Robot().judge.noise_at_standstill().gyro_density, kReference.gyro_density);
}

// An IMU of 10 Hz has two samples an interval, and ten a second.
TEST(MotionJudge, TheNoiseOfASlowImuIsThatOfItsLastSamples) {
  for (const int every : {20, 8, 4}) {
    Robot robot;
    robot.imu_every = every;
    robot.vibration = 4;
    const ImuNoise noise = robot.drive(50).noise;
    EXPECT_NEAR(noise.accel_density / kReference.accel_density, 4, 1.2) << every;
    EXPECT_NEAR(noise.gyro_density / kReference.gyro_density, 4, 1.2) << every;
  }
}

TEST(MotionJudge, AWheelThatSpinsOnGroundThatStandsThenIsContradicted) {
  const Config config = default_config({"wheel.slip_threshold=0"});  // the radar alone knows
  for (const double since : {-0.1, -0.3}) {                          // the second: of another time
    Robot robot(config);
    robot.wheel_speed = 0.3;
    robot.drive(5);
    robot.receive(stood(robot.now() + since, robot.now() + since + 0.4));
    const StateInput input = robot.next();
    EXPECT_EQ(input.standing, since == -0.1);
    EXPECT_EQ(input.wheel_contradicted, since == -0.1);
  }
}

TEST(RadarFinding, IsPublishedAsADisplacementInMetres) {
  constexpr TimeNs kFrom = 1'000'000'000, kTo = 2'000'000'000;
  const auto expect_said = [&](const Displacement& d, DisplacementKind kind, bool valid, double m) {
    EXPECT_TRUE(d.from == kFrom && d.to == kTo && d.source == "mine" && d.score == 0.6);
    EXPECT_EQ(d.kind, kind);
    EXPECT_EQ(d.valid, valid);
    EXPECT_DOUBLE_EQ(d.distance_m, m);
  };
  const Displacement stands = to_displacement(gpr::Standstill{kFrom, kTo, "mine", 1e-3, 0.6});
  expect_said(stands, DisplacementKind::kMotion, true, 0.0);
  EXPECT_EQ(stands.sigma_m, 1e-3);
  const Displacement on_track =
      to_displacement(gpr::TrackDisplacement{kFrom, kTo, "mine", false, -0.2, 0.05, 0.6});
  expect_said(on_track, DisplacementKind::kSequential, false, -0.2);
  EXPECT_EQ(on_track.sigma_m, 0.05);
  const Displacement path =
      to_displacement(gpr::PathLength{kFrom, kTo, "mine", true, 8.0, 0.6}, 0.05);
  expect_said(path, DisplacementKind::kMotion, true, 0.4);
  EXPECT_EQ(path.scale, 0.05);
}

TEST(MotionJudge, AnInvalidMeasurementIsNotUsed) {
  for (const bool valid : {true, false}) {
    Robot robot;
    gpr::TrackDisplacement measured = moved(kStart, kStart + 0.1);
    measured.valid = valid;
    robot.receive(measured);
    EXPECT_EQ(robot.next().displacements.size(), valid ? 1u : 0u);
  }
}

TEST(MotionJudge, ADisplacementIsHandedOutOnceWithTheFirstStateThatItDoesNotReachBeyond) {
  Robot robot;
  Displacement d = to_displacement(moved(kStart, kStart + 0.3));
  d.kind = DisplacementKind::kExternal;
  robot.judge.add_external(d);
  EXPECT_TRUE(robot.next().displacements.empty());
  const StateInput second = robot.next();
  ASSERT_EQ(second.displacements.size(), 1u);
  EXPECT_EQ(second.displacements[0].to, d.to);
  EXPECT_TRUE(robot.next().displacements.empty());
}

TEST(MotionJudge, UnsignedMotionOfAnotherProcessEntersWhateverTheCoherenceMay) {
  Robot robot(default_config({"gpr.coherence.use=never"}), kSpeed);
  Displacement d = to_displacement(moved(kStart, kStart + 0.2));
  d.kind = DisplacementKind::kMotion;
  robot.judge.add_external(d);
  const StateInput input = robot.next();
  ASSERT_EQ(input.displacements.size(), 1u);
  EXPECT_EQ(input.displacements[0].kind, DisplacementKind::kMotion);
}

TEST(MotionJudge, TheCoherenceEntersWhereTheWheelIsDoubtedUnlessToldOtherwise) {
  for (const char* name : names_like(CoherenceUse{})) {
    const CoherenceUse use = *find_choice<CoherenceUse>(name);
    for (const bool wheel_speaks : {true, false}) {
      Config config;
      config.gpr.coherence.use = use;
      Robot robot(config, kSpeed);
      robot.wheel_speaks = wheel_speaks;
      const gpr::PathLength path = went(kStart, kStart + 0.2, 2.0);
      Displacement in_metres = to_displacement(path, 0.05);  // as if that had been learnt
      in_metres.sigma_m = 0.02;
      robot.judge.add_radar(path, PlacedDisplacement(in_metres));
      const bool expected =
          use == CoherenceUse::kAlways || (use == CoherenceUse::kContradicted && !wheel_speaks);
      EXPECT_EQ(robot.next().displacements.size(), expected ? 1u : 0u) << name << wheel_speaks;
    }
  }
}

TEST(MotionJudge, ASlipIsToldOnceFlaggedAndContradictsTheWheel) {
  Robot robot({}, kSpeed);
  robot.vibration = 3.0;
  robot.drive(10);
  EXPECT_EQ(robot.slips_told, 0);
  EXPECT_EQ(robot.flags, 0);
  robot.wheel_speed = 2 * kSpeed;
  StateInput input = robot.drive(4);
  EXPECT_EQ(robot.slips_told, 1);
  EXPECT_EQ(robot.flags, kSlipping | kWheelFast);
  EXPECT_TRUE(input.wheel_contradicted);
  robot.wheel_speed = 0.5 * kSpeed;
  robot.drive(4);
  EXPECT_EQ(robot.flags, kSlipping | kWheelSlow);
  robot.wheel_speed = kSpeed;
  input = robot.drive(5);
  EXPECT_EQ(robot.flags, 0);
  EXPECT_FALSE(input.wheel_contradicted);
}

TEST(MotionJudge, WhereTheSpeedIsNotKnownTheWheelIsNotJudgedByIt) {
  Robot robot(default_config({"smoother.lag=2"}), kSpeed);
  robot.newest.carried = true;
  robot.drive(5);
  robot.newest.carried = false;
  robot.wheel_speed = 2 * kSpeed;
  robot.drive(9);  // less than the lag after the last state that rests on the wheel
  EXPECT_EQ(robot.flags, 0);
  robot.drive(4);
  EXPECT_EQ(robot.flags, kSlipping | kWheelFast);
}

TEST(MotionJudge, AfterAGapTheWheelIsJudgedFromTheFirstStateThatIsNotBridged) {
  Robot robot({}, kSpeed);
  robot.drive(5);
  robot.newest.bridged = true;
  robot.next();
  robot.wheel_speed = 2 * kSpeed;
  robot.drive(3);
  EXPECT_EQ(robot.flags, kImuGap);
  EXPECT_EQ(robot.slips_told, 0);
  robot.newest.bridged = false;
  robot.drive(3);
  EXPECT_EQ(robot.flags, kSlipping | kWheelFast);
}

TEST(MotionJudge, TheFlagsTellOfTheNewestState) {
  Robot robot({}, kSpeed);
  robot.newest.no_wheel = true;
  robot.drive(2);
  EXPECT_EQ(robot.flags, kNoWheel);
  robot.newest.no_wheel = robot.newest.solve.usable = false;
  robot.drive(2);
  EXPECT_EQ(robot.flags, kSolverFailed);
}

// The published speed is wrong and the wheel is right, as the radar says once a second.
TEST(MotionJudge, ASpeedPutRightIsNoWitnessAgainstTheWheelForOneLag) {
  Robot robot(default_config({"smoother.lag=2"}), kSpeed);
  robot.drive(10);
  robot.speed = 1.8 * kSpeed;
  StateInput input;
  for (int i = 1; i < 40 && !input.speed_correction; ++i) {
    input = robot.next();
    if (i % 5 != 0) continue;
    const gpr::PathLength path = went(robot.now() - 1.15, robot.now() - 0.05, 1.1 * kSpeed);
    Displacement in_metres = to_displacement(path, 1.0);
    in_metres.sigma_m = 0.2 * in_metres.distance_m;
    robot.judge.add_radar(path, PlacedDisplacement(in_metres));
  }
  ASSERT_TRUE(input.speed_correction);
  EXPECT_NEAR(input.speed_correction->speed, kSpeed, 0.01);
  robot.speed = kSpeed;
  robot.wheel_speed = 2 * kSpeed;
  robot.drive(9);
  EXPECT_EQ(robot.flags, 0);
  robot.drive(4);
  EXPECT_EQ(robot.flags, kSlipping | kWheelFast);
}

// The wheel's samples may come after the radar's answer about the same time.
TEST(MotionJudge, APathThatEndsAfterTheWheelsNewestSampleIsComparedLater) {
  Robot robot({}, kSpeed);
  robot.drive(10);
  const gpr::PathLength path = went(robot.now() - 0.5, robot.now() + 0.5, kSpeed);
  robot.judge.add_radar(path, PlacedDisplacement(to_displacement(path, 1.0)));
  EXPECT_FALSE(robot.judge.wheel_compared());
  robot.drive(5);
  EXPECT_TRUE(robot.judge.wheel_compared());
}

TEST(MotionJudge, WhatADecorrelationLengthIsIsLearntFromWhatIsPublished) {
  constexpr double kMetresPerLength = 0.04;
  for (const bool wheel_speaks : {true, false}) {
    Robot robot({}, kSpeed);
    robot.newest.no_wheel = !wheel_speaks;
    robot.drive(5);
    Displacement metres;
    for (int i = 0; i < 12; ++i) {
      robot.drive(5);
      metres =
          robot.judge.in_metres(went(robot.now() - 1.0, robot.now(), kSpeed / kMetresPerLength));
    }
    EXPECT_EQ(metres.valid, wheel_speaks);
    if (wheel_speaks) {
      EXPECT_NEAR(metres.distance_m, kSpeed, 0.01);
    }
  }
  EXPECT_EQ(Robot().judge.in_metres(moved(kStart, kStart + 1)).distance_m, 0.1);
}

TEST(MotionJudge, TooManyExternalDisplacementsBeforeTheStartAreDropped) {
  Robot robot;
  for (int i = 0; i < 3000; ++i) {
    Displacement d = to_displacement(moved(kStart, kStart + 0.1));
    d.kind = DisplacementKind::kExternal;
    robot.judge.add_external(d);
  }
  EXPECT_EQ(robot.next().displacements.size(), 2000u);
}

TEST(MotionJudge, AMovedGyroBiasIsFoundAtAStandstill) {
  Robot robot(default_config({"gpr.enabled=false"}));
  EXPECT_TRUE(robot.drive(5).standing);
  EXPECT_EQ(robot.flags, kStanding);
  robot.extra_rate = 5e-3;
  StateInput input;
  for (int i = 0; i < 8 && !input.gyro_bias; ++i) input = robot.next();
  ASSERT_TRUE(input.gyro_bias);
  EXPECT_TRUE(input.standing);
  EXPECT_LT((*input.gyro_bias - kBias - Eigen::Vector3d(0, 0, 5e-3)).norm(), 5e-4);
}

TEST(MotionJudge, AWheelSilentWithTheImuHasCountedOn) {
  for (const bool imu_speaks : {true, false}) {
    Robot robot({}, kSpeed);
    robot.drive(3);
    robot.imu_speaks = imu_speaks;
    robot.wheel_speaks = false;
    // The state is asked for once both are back.
    const TimeNs to = from_seconds(robot.now() + 0.4);
    robot.judge.add(ImuSample{to, {0, 0, 9.80665}, kBias});
    if (imu_speaks)
      for (int i = 1; i < 80; ++i)
        robot.judge.add(ImuSample{from_seconds(robot.now() + i * 0.005), {0, 0, 9.80665}, kBias});
    robot.judge.add(WheelSample{to, 3.0 + kSpeed * (0.6 + 0.4)});
    const StateInput input = robot.judge.judge(to);
    EXPECT_EQ(input.has_wheel, !imu_speaks);
    EXPECT_NEAR(rolled_m(input), imu_speaks ? 0.0 : 0.4 * kSpeed, 1e-9);
    EXPECT_EQ(input.steps.back().bridged, !imu_speaks);
  }
}

// Of IMU and wheel half a minute long, after a drive on laps.
TEST(MotionJudge, ARobotThatStandsInAGapOfAllDoesNotTurnInIt) {
  constexpr double kLaps_s = 60.0, kGap_s = 30.0;
  Robot robot({}, kSpeed);
  robot.extra_rate = 0.3;
  robot.drive(static_cast<int>(kLaps_s / to_seconds(kInterval)));
  robot.speed = robot.wheel_speed = robot.extra_rate = 0.0;
  robot.drive(10);
  const double stands_m = *robot.judge.wheel().distance(from_seconds(robot.now()));
  const TimeNs after = from_seconds(robot.now() + kGap_s);
  robot.judge.add(WheelSample{after, stands_m});
  robot.judge.add(ImuSample{after, {0, 0, 9.80665}, kBias});
  double turned = 0.0;
  for (const MotionStep& step : robot.judge.judge(after).steps)
    turned += step.gap_turn.value_or(0.0);
  EXPECT_NEAR(turned, 0.0, 0.05);
}

TEST(MotionJudge, TellsOfAStampRepeatedAndOfAJumpOfTheWheel) {
  MotionJudge judge{Config{}};
  EXPECT_TRUE(judge.add(ImuSample{from_seconds(1), {0, 0, 9.8}, kBias}));
  EXPECT_FALSE(judge.add(ImuSample{from_seconds(1), {0, 0, 9.9}, kBias}));
  for (const bool enabled : {true, false}) {
    Config config;
    config.wheel.enabled = enabled;
    Robot robot(config);
    robot.judge.add(WheelSample{from_seconds(1.0), 0.0});
    robot.judge.add(WheelSample{from_seconds(1.02), 50.0});
    EXPECT_FALSE(robot.judge.take_jump());  // the first of a fast vehicle, or a jump
    robot.judge.add(WheelSample{from_seconds(1.04), 50.0});
    EXPECT_EQ(robot.judge.take_jump(), enabled);
    if (!enabled) {
      EXPECT_FALSE(robot.next().has_wheel);
    }
  }
}

}  // namespace
}  // namespace gprodom
