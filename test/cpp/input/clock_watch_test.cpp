// Clocks that drift apart must be reported; delays that scatter or step must not be.
#include "input/clock_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace gprodom {
namespace {

constexpr TimeNs kStart = 1'700'000'000'000'000'000;

// Times told over a run, of a sensor at 20 Hz beside an IMU at 200 Hz. delay_s(t): from the moment
// of a measurement to its arrival.
int times_told(double seconds, double ppm, const std::function<double(double)>& delay_s) {
  ClockWatch watch;
  int told = 0;
  for (double t = 0; t < seconds; t += 0.05) {
    const double arrival = t + delay_s(t);
    const TimeNs imu_now = kStart + from_seconds(0.005 * std::floor(arrival / 0.005 + 0.4));
    told += watch.drifts(kStart + from_seconds(t * (1 + 1e-6 * ppm)), imu_now);
  }
  return told;
}

std::function<double(double)> scattered(double most_s) {
  return [most_s, random = std::mt19937(1)](double) mutable {
    return std::uniform_real_distribution<double>(0, most_s)(random);
  };
}

TEST(ClockWatch, DriftIsReportedWithinTwoMinutesAndWhileItLasts) {
  for (const double ppm : {-300.0, -100.0, 100.0}) {
    EXPECT_GT(times_told(120, ppm, scattered(0.003)), 0) << ppm;
    EXPECT_GT(times_told(3600, ppm, scattered(0.003)), 300) << ppm;
    EXPECT_GT(times_told(3600, ppm, scattered(0.1)), 0) << ppm;
  }
}

TEST(ClockWatch, GoodClocksWithDelaysAreNotReported) {
  for (const double ppm : {-20.0, 0.0, 20.0})
    for (const double most_s : {0.0, 0.003, 0.05, 0.2})
      EXPECT_EQ(times_told(3600, ppm, scattered(most_s)), 0) << ppm << " ppm, " << most_s << " s";
  EXPECT_EQ(times_told(600, 0, [](double t) { return t < 300 ? 0.0 : 0.05; }), 0);
  EXPECT_EQ(times_told(600, 0, [](double t) { return t < 300 ? 0.05 : 0.001; }), 0);
}

TEST(ClockWatch, StampsThatRestartAreJudgedAnew) {
  ClockWatch watch;
  int told = 0;
  TimeNs now = kStart;
  for (int run = 0; run < 20; ++run) {
    now += run % 2 ? 3600'000'000'000 : -1800'000'000'000;
    for (int i = 0; i < 40 * 20; ++i) {
      now += 50'000'000;
      told += watch.drifts(now - run * 5'000'000, now);
    }
  }
  EXPECT_EQ(told, 0);
}

}  // namespace
}  // namespace gprodom
