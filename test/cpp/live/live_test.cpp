#include "gprodom/live.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "live/latency_watch.h"
#include "live/runner.h"
#include "pipeline/test_drive.h"

namespace gprodom {
namespace {

// Everything that the inputs cause, in one.
Outputs collect(const std::vector<Input>& inputs, std::vector<OdometryEstimate>* placed) {
  Outputs all;
  Live live(default_config(), [&](const Outputs& o) {
    all.odometry.insert(all.odometry.end(), o.odometry.begin(), o.odometry.end());
    all.status.insert(all.status.end(), o.status.begin(), o.status.end());
    all.warnings.insert(all.warnings.end(), o.warnings.begin(), o.warnings.end());
    const auto& in_map = o.odometry_in_map;
    placed->insert(placed->end(), in_map.begin(), in_map.end());
  });
  for (const auto& input : inputs) live.push(input);
  live.stop();
  return all;
}

TEST(Live, TakesARadarFrontEndOfOnesOwn) {
  struct Silent : gpr::FrontEnd {
    explicit Silent(std::atomic<int>& ticks) : ticks(ticks) {}
    void add_trace(const GprTrace& /*trace*/) override {}
    std::vector<gpr::Finding> tick(TimeNs /*tick*/) override {
      ++ticks;
      return {};
    }
    void reset() override {}
    std::atomic<int>& ticks;
  };
  std::atomic<int> ticks{0};
  LiveOptions options;
  options.front_end = [&ticks] { return std::make_unique<Silent>(ticks); };
  // The data come faster than real time; with this budget no tick is late, and so none is dropped.
  Live live(
      default_config({"gpr.latency_budget=10"}), [](const Outputs&) {}, options);
  for (const auto& input : standing(10.0)) live.push(input);
  live.stop();
  EXPECT_NEAR(ticks, 10.0 / GprConfig().tick, 2.0);
}

TEST(Live, StopFinishesAllPushedInput) {
  std::vector<OdometryEstimate> placed;
  const auto inputs = standing(10.0);
  const Outputs all = collect(inputs, &placed);
  ASSERT_FALSE(all.odometry.empty());
  EXPECT_EQ(all.odometry.back().time, kDriveStart + 999 * kImuPeriod);
  EXPECT_EQ(placed.size(), all.odometry.size());
  EXPECT_GE(all.status.size(), 9u);
  EXPECT_LT(placed.back().p_odom_body.norm(), 0.01);
}

TEST(Live, ReportsLatenciesAndQueueLengths) {
  std::vector<OdometryEstimate> placed;
  const Outputs all = collect(standing(10.0), &placed);
  // The greatest that was told: queues tell of the second before.
  const auto value = [&all](const std::string& name) {
    double greatest = -1.0;
    for (const Status& status : all.status) {
      const auto found = std::find(status.names.begin(), status.names.end(), name);
      if (found == status.names.end()) continue;
      const auto index = static_cast<std::size_t>(found - status.names.begin());
      greatest = std::max(greatest, status.values[index]);
    }
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
    const std::vector<std::string> no_radar = {"gpr.enabled=false"};
    LiveOptions options;
    options.instance = 5.0;
    Live live(
        default_config(no_radar),
        [&](const Outputs& o) {
          all.status.insert(all.status.end(), o.status.begin(), o.status.end());
          all.warnings.insert(all.warnings.end(), o.warnings.begin(), o.warnings.end());
        },
        options);
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
  std::vector<OdometryEstimate> placed;
  auto inputs = standing(5.0);
  inputs.push_back(Command{kDriveStart, "reset", ""});
  const auto later = standing(5.0, kDriveStart + 500 * kImuPeriod);
  inputs.insert(inputs.end(), later.begin(), later.end());
  const Outputs all = collect(inputs, &placed);
  // No pose until the initialiser has again seen its standstill.
  const TimeNs reset = kDriveStart + 500 * kImuPeriod;
  TimeNs silence = 0;
  for (std::size_t i = 1; i < all.odometry.size(); ++i) {
    if (all.odometry[i].time >= reset && all.odometry[i - 1].time < reset) {
      silence = all.odometry[i].time - all.odometry[i - 1].time;
    }
  }
  EXPECT_GE(silence, from_seconds(0.8 * InitializerConfig().duration));
  EXPECT_TRUE(std::any_of(all.warnings.begin(), all.warnings.end(), [](const std::string& text) {
    return text.find("reset by command") != std::string::npos;
  }));
}

TEST(Live, RejectionsAndUnknownCommandsAreReported) {
  std::vector<OdometryEstimate> placed;
  std::vector<Input> inputs = standing(3.0);
  inputs.insert(inputs.begin() + 100, Command{kDriveStart, "explode", ""});
  inputs.insert(inputs.begin() + 100, Rejection{"IMU", "message ends within its fields"});
  const Outputs all = collect(inputs, &placed);
  auto told = [&](const std::string& part) {
    return std::any_of(all.warnings.begin(), all.warnings.end(), [&](const std::string& text) {
      return text.find(part) != std::string::npos;
    });
  };
  EXPECT_TRUE(told("IMU: message ends within its fields"));
  EXPECT_TRUE(told("COMMAND: unknown command"));
}

TEST(Live, ContradictorySettingsAreRefused) {
  Config config = default_config({"smoother.lag=0.2", "smoother.state_rate=1"});
  EXPECT_THROW(Live(config, [](const Outputs&) {}), std::exception);
}

}  // namespace
}  // namespace gprodom
