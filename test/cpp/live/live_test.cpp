#include "gprodom/live.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "live/latency_watch.h"
#include "live/runner.h"
#include "pipeline/test_drive.h"
#include "support/told.h"

namespace gprodom {
namespace {

// Everything that the inputs cause, in one.
Outputs collect(const std::vector<Input>& inputs) {
  Outputs all;
  Live live(default_config(), [&all](const Outputs& outputs) { append(all, outputs); });
  for (const auto& input : inputs) live.push(input);
  live.stop();
  return all;
}

TEST(Live, TakesARadarFrontEndOfOnesOwn) {
  std::atomic<int> ticks{0};
  LiveOptions options;
  options.front_end = saying([&ticks](TimeNs) {
    ++ticks;
    return std::vector<gpr::Finding>();
  });
  // The data come faster than real time; with this budget no tick is late, and so none is dropped.
  Live live(
      default_config({"gpr.latency_budget=10"}), [](const Outputs&) {}, options);
  for (const auto& input : standing(10.0)) live.push(input);
  live.stop();
  EXPECT_NEAR(ticks, 10.0 / GprConfig().tick, 2.0);
}

TEST(Live, StopFinishesAllPushedInput) {
  const Outputs all = collect(standing(10.0));
  ASSERT_FALSE(all.odometry.empty());
  EXPECT_EQ(all.odometry.back().time, kDriveStart + 999 * kImuPeriod);
  ASSERT_EQ(all.odometry_in_map.size(), all.odometry.size());
  EXPECT_GE(all.status.size(), 9u);
  EXPECT_LT(all.odometry_in_map.back().p_odom_body.norm(), 0.01);
}

TEST(Live, ReportsLatenciesAndQueueLengths) {
  const Outputs all = collect(standing(10.0));
  // The greatest that was told: queues tell of the second before.
  const auto value = [&all](const std::string& name) {
    double greatest = -1.0;
    for (const Status& status : all.status)
      greatest = std::max(greatest, value_of(status, name).value_or(-1.0));
    return greatest;
  };
  EXPECT_GT(value("latency.imu.p50_ms"), 0.0);
  EXPECT_LE(value("latency.imu.p50_ms"), value("latency.imu.p99_ms"));
  EXPECT_LE(value("latency.imu.p999_ms"), value("latency.imu.longest_ms"));
  EXPECT_GE(value("queue.input.longest"), 1.0);
  EXPECT_GE(value("queue.output.longest"), 0.0);
}

// Each Status has the instance of its estimator. Another instance on our channel degrades the
// health until it is silent.
TEST(Live, AnotherEstimatorOnItsChannelIsDegradedHealth) {
  const auto told = [](double heard) {
    Outputs all;
    LiveOptions options;
    options.instance = 5.0;
    const Config no_radar = default_config({"gpr.enabled=false"});
    Live live(
        no_radar, [&all](const Outputs& outputs) { append(all, outputs); }, options);
    for (const auto& input : standing(5.0)) {
      live.heard_status(heard);
      live.push(input);
    }
    live.stop();
    return all;
  };
  const std::string reason = "STATUS: another estimator publishes on our channels";
  const Outputs alone = told(5.0), two = told(7.0);
  ASSERT_FALSE(alone.status.empty());
  EXPECT_EQ(alone.status.back().health, HealthLevel::kOk);
  EXPECT_EQ(alone.status.back().names.back(), kInstance);
  EXPECT_EQ(alone.status.back().values.back(), 5.0);
  // On a slow machine the last one may come too late to count.
  const Status& first = two.status.front();
  EXPECT_EQ(first.health, HealthLevel::kDegraded);
  EXPECT_EQ(first.reasons.back(), reason);
  EXPECT_EQ(std::count(two.warnings.begin(), two.warnings.end(), reason), 1);
}

TEST(LatencyWatch, MeasuresPublishedMessagesAndDropsOthers) {
  LatencyWatch watch;
  for (TimeNs time = 1; time <= 10; ++time) watch.arrived(time);
  watch.published(3);
  watch.published(2);  // too late: forgotten with what came before 3
  watch.published(10);
  EXPECT_EQ(watch.latencies().count(), 2);
}

TEST(DurationHistogram, QuantilesAreRoundedUpByLessThanATenth) {
  DurationHistogram durations;
  for (int i = 1; i <= 1000; ++i) durations.add(1e-5 * i);
  for (const double share : {0.01, 0.5, 0.99}) {
    EXPECT_GE(durations.quantile(share), 1e-2 * share);
    EXPECT_LE(durations.quantile(share), 1.1e-2 * share);
  }
  EXPECT_DOUBLE_EQ(durations.quantile(1.0), 1e-2);
  EXPECT_DOUBLE_EQ(DurationHistogram().quantile(0.5), 0.0);
}

TEST(Live, ResetCommandRestartsTheEstimator) {
  auto inputs = standing(10.0);
  inputs.insert(inputs.begin() + 1000, Command{kDriveStart, "reset", ""});  // IMU and wheel: 5 s
  const Outputs all = collect(inputs);
  // No pose until the initialiser has again seen its standstill.
  const TimeNs reset = kDriveStart + 500 * kImuPeriod;
  TimeNs silence = 0;
  for (std::size_t i = 1; i < all.odometry.size(); ++i) {
    if (all.odometry[i].time >= reset && all.odometry[i - 1].time < reset) {
      silence = all.odometry[i].time - all.odometry[i - 1].time;
    }
  }
  EXPECT_GE(silence, from_seconds(0.8 * InitializerConfig().duration));
  EXPECT_GE(count_with(all.warnings, "reset by command"), 1);
}

TEST(Live, RejectionsAndUnknownCommandsAreReported) {
  std::vector<Input> inputs = standing(3.0);
  inputs.insert(inputs.begin() + 100, Command{kDriveStart, "explode", ""});
  inputs.insert(inputs.begin() + 100, Rejection{"IMU", "message ends within its fields"});
  const Outputs all = collect(inputs);
  EXPECT_GE(count_with(all.warnings, "IMU: message ends within its fields"), 1);
  EXPECT_GE(count_with(all.warnings, "COMMAND: unknown command"), 1);
}

TEST(Live, ContradictorySettingsAreRefused) {
  Config config = default_config({"smoother.lag=0.2", "smoother.state_rate=1"});
  EXPECT_THROW(Live(config, [](const Outputs&) {}), std::exception);
}

}  // namespace
}  // namespace gprodom
