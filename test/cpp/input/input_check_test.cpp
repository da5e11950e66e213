#include "input/input_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace gprodom {
namespace {

// Traces over ground, each another one.
GprTrace trace_of(int antenna, TimeNs time) {
  GprTrace trace;
  trace.time = time;
  trace.antenna_id = antenna;
  trace.sample_interval_s = 2e-10;
  trace.samples.resize(64);
  const double phase = to_seconds(time % 1'000'000'000);
  for (std::size_t i = 0; i < trace.samples.size(); ++i) {
    const double t = static_cast<double>(i);
    trace.samples[i] = static_cast<float>(1000 * std::exp(-t / 20) * std::sin(0.6 * t + phase));
  }
  return trace;
}

TEST(TwoAntennas, OnlyTracesOfTheFirstThatIsHeardAreUsed) {
  constexpr TimeNs kBegin = 1'700'000'000'000'000'000, kPeriod = 50'000'000;
  const Config config;
  Health health(10.0);
  InputCheck check(config, health);
  const auto accepts = [&](InputMessage message) { return check.accept(message); };
  ImuSample imu;  // the clock
  imu.time = kBegin;
  imu.acceleration.z() = 9.8;
  ASSERT_TRUE(accepts(imu));
  EXPECT_TRUE(accepts(trace_of(3, kBegin)));
  EXPECT_FALSE(accepts(trace_of(4, kBegin + kPeriod / 2)));
  EXPECT_TRUE(accepts(trace_of(3, kBegin + kPeriod)));
  EXPECT_FALSE(accepts(trace_of(4, kBegin + 3 * kPeriod / 2)));

  const Status status = health.status(kBegin);
  double refused = 0.0;
  for (std::size_t i = 0; i < status.names.size(); ++i)
    if (status.names[i].find("of another antenna") != std::string::npos) refused = status.values[i];
  EXPECT_EQ(refused, 2.0);
}

}  // namespace
}  // namespace gprodom
