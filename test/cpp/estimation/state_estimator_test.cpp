// A robot whose IMU falls silent, or whose gyro bias steps. What is observable again must be known
// again, and the covariance must contain what was lost.
#include "estimation/state_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimation/driven_intervals.h"

namespace gprodom {
namespace {

// A wheel that turns by a quarter too much, from the start on: only the passages show it.
TEST(Passages, OfTwoAntennasShowTheDistanceThatASlippingWheelDoesNot) {
  const auto driven = [](bool with_passages) {
    Noise random(3);
    StateEstimator estimator = at_ten_seconds(kSpeed);
    StateResult result;
    constexpr double kApart = 0.3;
    for (int i = 0; i < 100; ++i) {
      const double from = 10.0 + kStateInterval * i, to = from + kStateInterval;
      StateInput input = interval(from, {kSpeed, 0.0}, random);
      input.noise = {1.6e-3, 0.3};  // of a shaken IMU
      for (MotionStep& step : input.steps) step.wheel_m *= 1.25;
      input.slips = {{input.time, 0.0, 0.3}};
      if (with_passages && i > 5 && i % 3 == 0) {
        const TimeNs seen = from_seconds(to - 0.05), before = seen - from_seconds(kApart / kSpeed);
        input.passages = {{before, seen, {0.1 + kApart, 0, 0}, {0.1, 0, 0}, 0.003}};
      }
      result = estimator.add(input);
      if (with_passages && i > 5) {
        EXPECT_EQ(result.displacements_dropped, 0);
      }
    }
    return result;
  };
  const double truth = 100 * kStateInterval * kSpeed;
  EXPECT_GT(driven(false).state.p_odom.x(), truth + 0.5);
  const StateResult measured = driven(true);
  EXPECT_NEAR(measured.state.p_odom.x(), truth, 3 * sigma(measured, row::kP));
  EXPECT_LT(sigma(measured, row::kP), 0.15);
}

// A window that starts again, with a state that has not changed, while the wheel is silent: what
// the speed turns out to be later corrects the position as if it had gone on.
TEST(Restart, LosesNothingOfThePosition) {
  const auto driven = [](bool restarts) {
    Noise random(5);
    StateEstimator estimator = at_ten_seconds(kSpeed);
    StateResult result;
    for (int i = 0; i < 100; ++i) {
      StateInput input = interval(10.0 + kStateInterval * i, {kSpeed, 0.0}, random);
      input.noise.accel_density = 0.05;
      for (MotionStep& step : input.steps) step.acceleration.x() += 0.05;
      if (i >= 50 && i < 75) {
        input.has_wheel = false;
        for (MotionStep& step : input.steps) step.wheel_m = 0.0;
      }
      if (i == 74 && restarts) input.turned_axes = Eigen::Matrix3d::Identity();
      result = estimator.add(input);
    }
    return result;
  };
  const StateResult whole = driven(false), restarted = driven(true);
  EXPECT_LT((whole.state.p_odom - restarted.state.p_odom).norm(), 0.02);
  for (int k = row::kP; k < row::kP + 2; ++k)
    EXPECT_NEAR(sigma(restarted, k), sigma(whole, k), 0.1 * sigma(whole, k));
}

TEST(LongGap, StateAfterTheGapIsConsistentAfterOneLag) {
  StateEstimator estimator = at_ten_seconds(kSpeed);
  Noise random(1);

  StateResult result, at_return;
  double time = 10.0;
  for (; time < 100.0 - 1e-6; time += kStateInterval) {
    const bool silent = time > 30.0 - 1e-6 && time < 40.0 - 1e-6;
    result = estimator.add(interval(time, {kSpeed, kTurn, 0.0, silent}, random));
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
  EXPECT_GT(sigma(result, row::kTheta + 2), 1.0);
  EXPECT_NEAR(sigma(result, row::kTheta + 2), sigma(at_return, row::kTheta + 2), 0.02);
  EXPECT_LT(sigma(result, row::kTheta), 0.01);
  EXPECT_LT(sigma(result, row::kV), 0.05);
}

// A covariance that is too large after a short gap would let revisits and slips bend the track.
TEST(LongGap, ShortGapLosesLittle) {
  StateEstimator estimator = at_ten_seconds(kSpeed);
  Noise random(1);
  StateResult result;
  for (int i = 0; i < 50; ++i) {  // of 10 s the last
    const bool silent = i >= 45;
    result = estimator.add(interval(10.0 + i * kStateInterval, {kSpeed, kTurn, 0, silent}, random));
  }
  EXPECT_TRUE(result.carried);
  EXPECT_LT(sigma(result, row::kTheta + 2), 1.05 * std::sqrt(5 * kTurnVariance));
  EXPECT_GT(sigma(result, row::kTheta + 2), std::sqrt(3 * kTurnVariance));  // some are solved
  EXPECT_NEAR(sigma(result, row::kTheta), 0.02, 0.01);                      // 0.02 rad/sqrt(s)
}

// 20 s straight on with a bias that moved at once, then a standstill that shows it.
TEST(BiasStep, AStandstillSetsTheBiasRightAndTheHeadingIsOwnedUpTo) {
  constexpr double kStep = 5e-3;  // rad/s
  StateEstimator estimator = at_ten_seconds(0.0);
  Noise random(1);
  StateResult result, at_stop;
  for (int i = 0; i < 250; ++i) {  // off in intervals 25 to 125, which begin and end at half speed
    const bool driving = i >= 25 && i <= 125, proven = i < 25 || i >= 130;
    const double push = (i == 25) - (i == 125);
    Motion motion{driving ? kSpeed * (1 - 0.5 * std::abs(push)) : 0.0, 0.0};
    motion.push = push * kSpeed / kStateInterval;
    motion.bias = i >= 25 ? kStep : 0.0;
    motion.standing = proven;
    StateInput input = interval(10.0 + i * kStateInterval, motion, random);
    if (i == 130) input.gyro_bias = Eigen::Vector3d(1e-4, -1e-4, kStep - 1e-4);
    result = estimator.add(input);
    ASSERT_TRUE(result.solve.usable) << i;
    if (i < 130) at_stop = result;
  }
  EXPECT_NEAR(result.state.gyro_bias.z(), kStep, 2e-4);
  EXPECT_LT(result.state.v_odom.norm(), 0.002);
  EXPECT_LT((result.state.p_odom - at_stop.state.p_odom).norm(), 0.02);
  const double yaw_error =
      2 * std::atan2(result.state.q_odom_body.z(), result.state.q_odom_body.w());
  EXPECT_GT(yaw_error, 0.05);  // not seen by anything
  EXPECT_LT(yaw_error, 3 * sigma(result, row::kTheta + 2));
  EXPECT_GT(yaw_error, 0.5 * sigma(result, row::kTheta + 2));
  EXPECT_LT(std::abs(result.state.p_odom.y()), 3 * sigma(result, row::kP + 1));
  EXPECT_LT(sigma(result, row::kTheta), 0.01);
}

// The standstill ends with the interval that tells of the step: what it has shown stays known.
TEST(BiasStep, TheNewBiasIsKnownThoughTheRobotDrivesOffAtOnce) {
  constexpr double kStep = 5e-3;  // rad/s
  StateEstimator estimator = at_ten_seconds(0.0);
  Noise random(1);
  StateResult at_stop, result;
  for (int i = 0; i < 40; ++i) {
    Motion motion{i > 30 ? kSpeed : 0.0, 0.0};
    motion.push = i == 31 ? kSpeed / kStateInterval : 0.0;
    if (i == 31) motion.speed *= 0.5;
    motion.bias = kStep;
    motion.standing = i == 30;
    StateInput input = interval(10.0 + i * kStateInterval, motion, random);
    if (i == 30) input.gyro_bias = Eigen::Vector3d(0, 0, kStep);
    result = estimator.add(input);
    ASSERT_TRUE(result.solve.usable) << i;
    if (i == 30) at_stop = result;
  }
  EXPECT_NEAR(result.state.gyro_bias.z(), kStep, 1e-3);
  EXPECT_LT(sigma(result, row::kBg + 2), 1.2e-3);
  EXPECT_LT(sigma(result, row::kTheta + 2), sigma(at_stop, row::kTheta + 2) + 5e-3);
}

// For 5 s the wheel seemed to slip, but the published speed was wrong.
TEST(SpeedCorrection, PutsSpeedAndPlaceRightAndHeadingStays) {
  constexpr double kBelieved = 0.3;  // m/s
  StateEstimator estimator = at_ten_seconds(kBelieved);
  Noise random(1);
  StateResult result, before;
  for (int i = 0; i < 100; ++i) {
    StateInput input = interval(10.0 + i * kStateInterval, {kSpeed, kTurn}, random);
    input.wheel_contradicted = i < 25;
    if (i == 25) input.speed_correction = SpeedCorrection{kSpeed, 0.1, (kSpeed - kBelieved) * 5.0};
    result = estimator.add(input);
    ASSERT_TRUE(result.solve.usable) << i;
    if (i == 24) before = result;
    if (i != 25) continue;
    const Eigen::Vector3d ahead = before.state.q_odom_body * Eigen::Vector3d::UnitX();
    const double moved = ahead.dot(result.state.p_odom - before.state.p_odom);
    EXPECT_NEAR(moved, (kSpeed - kBelieved) * 5.0 + kSpeed * kStateInterval, 0.02);
    EXPECT_GT(sigma(result, row::kP), 0.1);  // the way was not straight
  }
  const Eigen::Vector3d v_body = result.state.q_odom_body.conjugate() * result.state.v_odom;
  EXPECT_NEAR(v_body.x(), kSpeed, 0.02);
  const double yaw = 2 * std::atan2(result.state.q_odom_body.z(), result.state.q_odom_body.w());
  EXPECT_NEAR(yaw, kTurn * 100 * kStateInterval, 0.02);
  EXPECT_LT(sigma(result, row::kTheta + 2), 0.025);
}

const double kScaleSigma = WheelConfig().scale_sigma;

// Intervals `from` to `to` of a drive whose accelerations are 5 % more than the wheel's speeds
// change by.
StateResult push(StateEstimator& estimator, int from, int to,
                 const Eigen::Vector3d& accel_bias = Eigen::Vector3d::Zero(),
                 bool wheel_late = false, std::optional<ImuNoise> noise = std::nullopt) {
  Noise random(static_cast<unsigned>(from) + 1);
  double speed = 0;
  for (int k = 0; k < from; ++k) speed += 0.5 * std::cos(0.2 * k) * kStateInterval;
  StateResult result;
  for (int k = from; k < to; ++k) {
    Motion motion{speed, 0.0};
    motion.push = 0.5 * std::cos(0.2 * k) * 1.05;
    StateInput input = interval(10.0 + k * kStateInterval, motion, random);
    for (MotionStep& step : input.steps) {
      speed += 0.5 * std::cos(0.2 * k) * step.dt;
      step.wheel_m = speed * step.dt;
      step.acceleration += accel_bias;
    }
    input.wheel_late = wheel_late;
    if (noise) input.noise = *noise;
    result = estimator.add(input);
    EXPECT_TRUE(result.solve.usable);
  }
  return result;
}

// Gravity shows four times the bias that an accelerometer is believed to have. So its scale may be
// wrong as well, and the wheel's scale is neither learnt from it nor known any better.
TEST(HeldScale, AnAccelerometerOutOfCalibrationTellsNoScale) {
  for (const bool calibrated : {true, false}) {
    const Eigen::Vector3d bias(0, 0, calibrated ? 0.0 : 4 * kAccelBiasSigma);
    StateEstimator estimator = at_ten_seconds(0.0, kScaleSigma, bias);
    const StateResult result = push(estimator, 0, 100, bias);
    const double scale = result.state.wheel_scale, sigma_scale = sigma(result, row::kScale);
    if (calibrated) {
      EXPECT_NEAR(scale, 1 / 1.05, 0.01);
      EXPECT_LT(sigma_scale, 0.5 * kScaleSigma);
    } else {
      EXPECT_NEAR(scale, 1.0, 1e-4);
      EXPECT_NEAR(sigma_scale, kScaleSigma, 1e-4);
      EXPECT_GE(sigma(result, row::kP), 0.99 * kScaleSigma * result.state.p_odom.x());
    }
  }
}

// As where a driver smooths the wheel's speeds: known only after some driving.
TEST(HeldScale, OfAWheelThatComesLateIsWhatItWasAtTheStart) {
  StateEstimator estimator = at_ten_seconds(0.0, kScaleSigma);
  estimator.record();
  const double learnt = push(estimator, 0, 40).state.wheel_scale;
  const StateResult result = push(estimator, 40, 100, Eigen::Vector3d::Zero(), true);
  EXPECT_LT(learnt, 0.99);  // so there is something to undo
  EXPECT_NEAR(result.state.wheel_scale, 1.0, 1e-4);
  EXPECT_NEAR(sigma(result, row::kScale), kScaleSigma, 1e-4);
  EXPECT_GE(sigma(result, row::kP), 0.99 * kScaleSigma * result.state.p_odom.x());
  for (const NavState& x : estimator.recorded()->solve({})) EXPECT_NEAR(x.wheel_scale, 1.0, 2e-3);
}

// Accelerations on a robot that shakes have not shown the scale after 20 s. As their errors are
// coloured, those of six times as long do not show it either, in the solution over all data.
TEST(HeldScale, ThatAccelerationsHaveNotShownIsHeldOverAllData) {
  StateEstimator estimator = at_ten_seconds(0.0, kScaleSigma);
  estimator.record();
  const ImuNoise shaking{1.6e-4, 0.15};
  const StateResult result = push(estimator, 0, 600, Eigen::Vector3d::Zero(), false, shaking);
  EXPECT_NEAR(result.state.wheel_scale, 1.0, 1e-4);
  for (const NavState& x : estimator.recorded()->solve({})) EXPECT_NEAR(x.wheel_scale, 1.0, 1e-3);
}

// From rest through a bend of two radians to rest, with a wheel that is `late_s` behind.
struct LateDrive {
  double x = 0.0, y = 0.0, yaw = 0.0;  // true, at the end
  StateResult result;
};

LateDrive bend_by_late_wheel(double late_s, double known_delay_s) {
  constexpr double kRamp = 1.0, kEnd = 6.0;  // s
  const auto speed = [](double t) {
    return std::clamp(std::min(t, kEnd - t) / kRamp, 0.0, 1.0);  // m/s
  };
  const auto rate = [](double t) { return t > 1.0 && t < 3.0 ? 1.0 : 0.0; };  // rad/s
  StateEstimator estimator = at_ten_seconds(0.0);
  Noise random(1);
  LateDrive drive;
  double t = 0.0;
  while (t < kEnd + 1.0) {
    StateInput input = interval(10.0 + t, {}, random);
    input.noise = {1.6e-4, 0.12};  // vibration hides the wheel's delay
    for (MotionStep& step : input.steps) {
      const double v = speed(t), push = (speed(t + step.dt) - v) / step.dt;
      step.acceleration += Eigen::Vector3d(push, v * rate(t), 0.0);
      step.angular_velocity.z() += rate(t);
      step.wheel_m = speed(t - late_s) * step.dt;
      drive.yaw += 0.5 * rate(t) * step.dt;
      drive.x += v * std::cos(drive.yaw) * step.dt;
      drive.y += v * std::sin(drive.yaw) * step.dt;
      drive.yaw += 0.5 * rate(t) * step.dt;
      t += step.dt;
    }
    input.wheel_delay_s = known_delay_s;
    drive.result = estimator.add(input);
  }
  return drive;
}

double nees_of_place(const LateDrive& drive) {
  const Eigen::Vector2d error =
      drive.result.state.p_odom.head<2>() - Eigen::Vector2d(drive.x, drive.y);
  const Eigen::Matrix2d P = drive.result.covariance.block<2, 2>(row::kP, row::kP);
  return error.dot(P.inverse() * error);
}

// The bend's distances have got the wrong headings: no sensor shows it, and the covariance has it.
TEST(LateWheel, CovarianceContainsWhatItsDelayDoesInABend) {
  constexpr double kLate = 0.4;  // s
  EXPECT_LT(nees_of_place(bend_by_late_wheel(0.0, 0.0)), 6.0);
  EXPECT_GT(nees_of_place(bend_by_late_wheel(kLate, 0.0)), 50.0);
  EXPECT_LT(nees_of_place(bend_by_late_wheel(kLate, kLate)), 6.0);
}

// The pose graph takes a state after a second, and waits four while a measurement is to come. With
// each it learns where the one that it took last lies now, also if others were left out between.
TEST(Settled, StatesWaitForMeasurementsToCome) {
  Noise random(4);
  StateEstimator estimator = at_ten_seconds(kSpeed);
  std::optional<NavState> before;
  for (int i = 0; i < 100; ++i) {
    StateInput input = interval(10.0 + kStateInterval * i, {kSpeed, 0.0}, random);
    const bool waits = i >= 40 && i < 60;
    if (waits) input.keep_since = from_seconds(10.0 + kStateInterval * 40);
    const StateResult result = estimator.add(input);
    ASSERT_TRUE(result.settled);
    if (i >= 60 || (i > 5 && i < 40)) {
      EXPECT_NEAR(to_seconds(result.state.time - result.settled->time), 1.0, 1e-6) << i;
    } else if (i == 59) {
      EXPECT_NEAR(to_seconds(result.state.time - result.settled->time), 4.0, 1e-6);
    }
    if (before) {
      ASSERT_TRUE(result.before_settled) << i;
      EXPECT_EQ(result.before_settled->time, before->time) << i;
      EXPECT_GE(result.settled->time, before->time) << i;
    }
    before = result.settled;
  }
}

}  // namespace
}  // namespace gprodom
