// The delay of a wheel, from changes of speed, in the presence of noise, slip and bias.
#include "motion/wheel_delay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noise.h"

namespace gprodom {
namespace {

constexpr double kInterval_s = 0.2;

struct Wheel {
  double late_s = 0.0, noise_mps = 0.0;
  double slipping = 0.0;   // of the time, for a second at once, half as fast again
  double accel_mps = 0.0;  // of the IMU's change of speed in an interval
};

// A minute of a robot that speeds up and slows down, more than one interval apart.
double shown(const Wheel& wheel) {
  WheelDelay delay;
  Noise n(1);
  const auto speed = [](double t) {
    return 1.0 + 0.4 * std::sin(1.3 * t) + 0.2 * std::sin(2.9 * t);
  };
  const auto reported = [&](double t) {
    const bool slips = std::fmod(t, 10.0) < 10.0 * wheel.slipping;
    return speed(t - wheel.late_s) * (slips ? 1.5 : 1.0) + wheel.noise_mps * n();
  };
  double imu = speed(0), by_wheel = reported(0);
  for (int k = 1; k < 300; ++k) {
    const double next = reported(k * kInterval_s);
    const double by_imu = speed(k * kInterval_s) - imu + wheel.accel_mps * n();
    delay.add(by_imu, next - by_wheel, kInterval_s);
    imu = speed(k * kInterval_s);
    by_wheel = next;
  }
  return delay.delay_s();
}

TEST(WheelDelay, IsFoundToAFractionOfAnInterval) {
  for (const double late_s : {0.12, 0.2, 0.33}) {
    EXPECT_NEAR(shown({late_s}), late_s, 0.04);
    const double in_noise = shown({late_s, 0.03, 0.0, 0.02});
    EXPECT_NEAR(in_noise, late_s, 0.05);
  }
}

// At a constant speed only noise can be compared; checked at each moment of two minutes.
TEST(WheelDelay, IsNotReportedAtAConstantSpeed) {
  constexpr int kDrives = 300;
  for (const double wheel_mps : {0.005, 0.01, 0.03}) {
    int told = 0;
    for (int seed = 0; seed < kDrives; ++seed) {
      WheelDelay delay;
      Noise n(seed);
      bool once = false;
      double before = 0.0;
      for (int k = 0; k < 600; ++k) {
        const double now = wheel_mps * n();
        delay.add(0.01 * n(), now - before, kInterval_s);
        before = now;
        once |= delay.delay_s() > 0.0;
      }
      told += once ? 1 : 0;
    }
    EXPECT_LE(told, 0.02 * kDrives) << wheel_mps;
  }
}

TEST(WheelDelay, NeitherNoiseNorSlipsAreADelay) {
  EXPECT_EQ(shown({}), 0.0);
  EXPECT_EQ(shown({0.0, 0.1}), 0.0);
  EXPECT_EQ(shown({0.0, 0.03, 0.3}), 0.0);
  EXPECT_EQ(shown({0.0, 0.0, 0.0, 0.1}), 0.0);
}

TEST(WheelDelay, IsNotReportedAtFirstNorAcrossBreaks) {
  WheelDelay delay;
  for (int k = 0; k < 1000; ++k) {
    delay.add(std::sin(0.3 * k), std::sin(0.3 * (k - 1)), kInterval_s);
    if (k % 5 == 0) delay.interrupt();
  }
  EXPECT_EQ(delay.delay_s(), 0.0);
}

}  // namespace
}  // namespace gprodom
