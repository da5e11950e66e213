// Starts: of a robot whose engine shakes it, and on the move.
#include "estimation/initializer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;

const Vector3d kBias(0.017, -0.014, 0.0045);

// Two seconds of an IMU at 120 Hz: force and rate in body, an engine's vibration on both.
std::vector<ImuSample> samples(const Vector3d& force, const Vector3d& rate, double vibration,
                               double swing = 0.0) {
  std::vector<ImuSample> all;
  for (int i = 0; i < 240; ++i) {
    const double t = i / 120.0;
    const double shake = vibration * std::sin(2 * M_PI * 31 * t);
    all.push_back({from_seconds(t), force + Vector3d(shake, 0.3 * shake, 0.2 * shake),
                   rate + Vector3d(0, 0, 0.02 * shake + swing * std::sin(3 * t))});
  }
  return all;
}

WheelAtStart wheel_of(double path_m, double begin_mps = 0.0, double end_mps = 0.0) {
  WheelAtStart wheel;
  wheel.received = true;
  wheel.path_m = path_m;
  wheel.begin_mps = begin_mps;
  wheel.end_mps = end_mps;
  return wheel;
}

StateMatrix covariance_of(const InitialState& initial) {
  return (initial.prior.A.transpose() * initial.prior.A).inverse();
}

TEST(Initializer, RunningEngineCountsAsStandstill) {
  const auto shaken = samples({0.1, -0.9, 9.75}, kBias, 0.7);
  WheelAtStart wheel = wheel_of(0.022);  // the noise of a wheel speed without a sign
  const Initialization start = initialize(Config{}, shaken, wheel);
  ASSERT_TRUE(start.initial) << start.refusal;
  EXPECT_FALSE(start.initial->on_the_move);
  EXPECT_LT((start.initial->state.gyro_bias - kBias).norm(), 1e-3);
  // Without a wheel that stands, it cannot be distinguished from a robot that drives.
  EXPECT_FALSE(initialize(Config{}, shaken, {}).initial);
  // A robot that swings does not stand, nor does one whose wheel turns.
  EXPECT_FALSE(initialize(Config{}, samples({0.1, -0.9, 9.75}, kBias, 0.7, 0.03), wheel).initial);
  wheel.path_m = 0.2;
  EXPECT_FALSE(initialize(Config{}, shaken, wheel).initial);
}

// In two seconds the robot sets off, or comes to rest, for a quarter of a second at 0.3 m/s^2: 9
// mm.
TEST(Initializer, RobotThatSetsOffOrHasJustStoppedDoesNotStand) {
  for (const bool sets_off : {true, false}) {
    auto going = samples({0, 0, kStandardGravity}, kBias, 0.001);
    for (ImuSample& s : going) {
      if (sets_off && s.time > from_seconds(1.75)) s.acceleration.x() += 0.3;
      if (!sets_off && s.time < from_seconds(0.25)) s.acceleration.x() -= 0.3;
    }
    WheelAtStart wheel = wheel_of(0.009);
    (sets_off ? wheel.end_mps : wheel.begin_mps) = wheel.path_m / WheelAtStart::kSpeedOver;
    const Initialization start = initialize(Config{}, going, wheel);
    EXPECT_FALSE(start.initial);
    EXPECT_NE(start.refusal.find("in half a second"), std::string::npos) << start.refusal;
  }
  // Noise of a wheel at rest is the same all the time.
  const auto still = samples({0, 0, 9.8}, kBias, 0.001);
  EXPECT_TRUE(initialize(Config{}, still, wheel_of(0.022, 0.011, 0.011)).initial);
}

// A robot that slows down by 0.8 m/s^2 has at the end less than the mean speed of the last half
// second.
TEST(Initializer, SpeedOnTheMoveIsThatOfTheLastSample) {
  const double slower = -0.8, end = 0.3;
  const auto braking = samples({slower, 0, kStandardGravity}, Vector3d::Zero(), 0.0);
  const double seconds = to_seconds(braking.back().time), half = WheelAtStart::kSpeedOver / 2;
  const WheelAtStart wheel = wheel_of(seconds * (end - slower * seconds / 2),
                                      end - slower * (seconds - half), end - slower * half);
  const Initialization start = initialize_moving(Config{}, braking, wheel);
  ASSERT_TRUE(start.initial) << start.refusal;
  EXPECT_NEAR(start.initial->state.v_odom.x(), end, 0.01);
}

// What shows in the IMU alone is not refused, but the tilt is no surer than the parts' means agree.
TEST(Initializer, TiltIsAsSureAsTheStandstillWasSteady) {
  const auto tilt_sigma = [](double pushed) {
    auto all = samples({0, 0, kStandardGravity}, kBias, 0.001);
    for (ImuSample& s : all)
      if (s.time > from_seconds(1.9)) s.acceleration.x() += pushed;
    const Initialization start = initialize(Config{}, all, {});
    EXPECT_TRUE(start.initial) << start.refusal;
    const StateMatrix P = covariance_of(*start.initial);
    const int pitch = row::kTheta + 1, bias = row::kBa;
    // Of the mean force: tilt and bias together.
    const double g = kStandardGravity;
    return std::sqrt(g * g * P(pitch, pitch) + P(bias, bias) - 2 * g * std::abs(P(pitch, bias)));
  };
  EXPECT_LT(tilt_sigma(0.0), 0.001);
  EXPECT_GT(tilt_sigma(0.3), 0.01);  // the mean is off by 0.015
}

// Faster by 1 m/s^2 in a bend of 0.5 rad/s, on a slope: what wheel and gyro explain is no tilt.
TEST(Initializer, OnTheMoveGravityIsWhatTheWheelDoesNotExplain) {
  const double roll = 0.05, g = kStandardGravity;
  const Vector3d gravity(0, g * std::sin(roll), g * std::cos(roll));
  const WheelAtStart wheel = wheel_of(4.0, 1.25, 2.75);  // 1 m/s at first, 3 m/s at the end
  const Vector3d rate(0, 0, 0.5);
  const Vector3d force = gravity + Vector3d(1, 0, 0) + rate.cross(Vector3d(2, 0, 0));
  const Initialization start = initialize_moving(Config{}, samples(force, rate, 0.3), wheel);
  ASSERT_TRUE(start.initial) << start.refusal;
  const NavState& x = start.initial->state;
  EXPECT_TRUE(start.initial->on_the_move);
  const Vector3d up = x.q_odom_body.conjugate() * Vector3d::UnitZ();
  EXPECT_LT((up - gravity / g).norm(), 0.02);
  EXPECT_NEAR((x.q_odom_body.conjugate() * x.v_odom).x(), 3.0, 0.02);
  const StateMatrix covariance = covariance_of(*start.initial);
  EXPECT_NEAR(std::sqrt(covariance(row::kBg, row::kBg)), 0.002, 1e-6);
  EXPECT_GT(std::sqrt(covariance(row::kTheta, row::kTheta)), 0.01);
  EXPECT_FALSE(initialize_moving(Config{}, samples(force, rate, 0.3), {}).initial);
}

// Four seconds on a slope with changing speed, and the wheel's speeds with a slip from 1.5 s to 3
// s.
bool agrees(double slip, double vibration) {
  Noise noise(1);
  const Vector3d gyro_bias(0.002, -0.002, 0.002);
  const auto speed = [](double t) { return 0.6 + 0.05 * std::sin(2 * t); };
  std::vector<ImuSample> all;
  for (int i = 0; i <= 400; ++i) {
    const double t = i * 0.01;
    const Vector3d shake(vibration * noise(), vibration * noise(), 0);
    all.push_back({from_seconds(t),
                   Vector3d(0.3 + 0.1 * std::cos(2 * t), 0, kStandardGravity) + shake, gyro_bias});
  }
  WheelSpeeds wheel;
  for (int k = 0; k < 20; ++k) {
    const double t = (k + 0.5) * WheelSpeeds::kPart;
    wheel.mps.push_back(speed(t) * (t > 1.5 && t < 3 ? 1 + slip : 1.0) + 0.005 * noise());
  }
  return speeds_agree(all, wheel);
}

// The slope is a constant acceleration; a slip, or a skid, begins and ends with a jump. Vibration
// is no slip.
TEST(Initializer, AWheelThatSlipsDisagreesWithTheAccelerations) {
  for (const double vibration : {0.01, 0.3}) {
    EXPECT_TRUE(agrees(0.0, vibration));
    EXPECT_FALSE(agrees(0.5, vibration));
    EXPECT_FALSE(agrees(-0.5, vibration));
  }
  EXPECT_FALSE(speeds_agree({}, {}));
}

// What is left is surer: a slip that begins soon after the start would hide in the first state.
TEST(Initializer, OnTheMoveAWheelThatAgreesMakesTheStateSurer) {
  WheelAtStart wheel = wheel_of(2.0, 1.0, 1.0);
  const auto sigma_of = [&](bool agrees, int i) {
    wheel.agrees = agrees;
    const auto level = samples({0, 0, kStandardGravity}, Vector3d::Zero(), 0.0);
    return std::sqrt(covariance_of(*initialize_moving(Config{}, level, wheel).initial)(i, i));
  };
  for (const int i : {row::kTheta + 1, row::kV})
    EXPECT_LT(sigma_of(true, i), 0.5 * sigma_of(false, i)) << i;
}

}  // namespace
}  // namespace gprodom
