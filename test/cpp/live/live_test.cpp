#include "gprodom/live.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <set>
#include <thread>

#include "live/latency_watch.h"
#include "live/message_queue.h"
#include "live/runner.h"
#include "pipeline/test_drive.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace gprodom {
namespace {

// Everything that the inputs cause, in one.
Outputs collect(const std::vector<Input>& inputs, const Config& config = default_config(),
                const LiveOptions& options = {}, double heard = 0.0) {
  Outputs all;
  Live live(
      config, [&all](const Outputs& outputs) { append(all, outputs); }, options);
  for (const auto& input : inputs) {
    if (heard > 0.0) live.heard_status(heard);
    live.push(input);
  }
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
  collect(standing(10.0), default_config({"gpr.latency_budget=10"}), options);
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
  LiveOptions options;
  options.instance = 5.0;
  const Config no_radar = default_config({"gpr.enabled=false"});
  const std::string reason = "STATUS: another estimator publishes on our channels";
  const Outputs alone = collect(standing(5.0), no_radar, options, 5.0);
  const Outputs two = collect(standing(5.0), no_radar, options, 7.0);
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

using std::chrono::milliseconds;

TEST(MessageQueue, DropsAndCountsWhatDoesNotFit) {
  MessageQueue<int> queue(3);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(queue.push(i), i < 3);
  EXPECT_EQ(queue.take_dropped(), 2);
  EXPECT_EQ(queue.take_dropped(), 0);
  EXPECT_EQ(queue.pop_all(milliseconds(0)), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(queue.push(5));
}

TEST(MessageQueue, ClosedQueueReturnsItsItems) {
  MessageQueue<int> queue(3);
  queue.push(1);
  queue.close();
  EXPECT_FALSE(queue.push(2));
  EXPECT_EQ(queue.take_dropped(), 0);  // at the end nothing is lost that was asked for
  EXPECT_FALSE(queue.finished());
  EXPECT_EQ(queue.pop_all(milliseconds(0)).size(), 1u);
  EXPECT_TRUE(queue.finished());
}

TEST(MessageQueue, ManyProducersLoseNothingThatFits) {
  constexpr int kEach = 20000;
  MessageQueue<int> queue(2 * kEach);
  std::vector<int> received;
  std::thread consumer([&] {
    while (!queue.finished()) {
      for (const int item : queue.pop_all(milliseconds(1000))) received.push_back(item);
    }
  });
  auto produce = [&](int first) {
    for (int i = 0; i < kEach; ++i) queue.push(first + 2 * i);
  };
  std::thread odd(produce, 1);
  produce(0);
  odd.join();
  queue.close();
  consumer.join();
  ASSERT_EQ(received.size(), 2u * kEach);
  int next[2] = {0, 1};  // each producer's items stay in order
  for (const int item : received) {
    EXPECT_EQ(item, next[item % 2]);
    next[item % 2] += 2;
  }
}

namespace fs = std::filesystem;

class RunnerTest : public ::testing::Test {
 protected:
  RunnerTest() { fs::create_directory(folder_ / "state"); }

  // Everything that is told when a robot that stands gets these commands after its first message.
  std::vector<std::string> told(const std::vector<std::string>& settings,
                                const std::vector<Command>& commands) {
    Runner runner(default_config(settings), Execution::kInline);
    Outputs all;
    std::vector<Input> inputs = standing(0.1);
    inputs.insert(inputs.begin() + 1, commands.begin(), commands.end());
    for (const Input& input : inputs) append(all, runner.feed(input));
    append(all, runner.finish());
    return all.warnings;
  }
  static bool has(const std::vector<std::string>& told, const std::string& part) {
    return count_with(told, part) > 0;
  }

  TemporaryFolder folder_;
  std::string kept_ = "state.directory=" + (folder_ / "state");
};

TEST_F(RunnerTest, EveryCommandNameIsKnownAndAnotherIsRefusedWithThem) {
  const std::string unknown = "unknown command, expected reset, save_map, load_map or locate_at";
  for (const char* name : names_like(CommandName{}))
    EXPECT_FALSE(has(told({}, {{0, name, ""}}), unknown)) << name;
  EXPECT_TRUE(has(told({}, {{0, "rset", ""}}), unknown));
}

// With a folder for maps, or without one.
TEST_F(RunnerTest, CommandsAreAnswered) {
  const std::string reset = name_of(CommandName::kReset);
  const std::string only_read = "state.map=read_only";
  struct Case {
    std::vector<std::string> settings;
    Command command;
    std::string answer;
  };
  for (const Case& asked :
       {Case{{}, {0, reset, ""}, "the ground is kept"},
        Case{{}, {0, reset, kResetAll}, "all is forgotten"},
        Case{{}, {0, "save_map", "yard"}, "state.directory is empty"},
        Case{{}, {0, "load_map", "yard"}, "state.directory is empty"},
        Case{{kept_}, {0, "load_map", "yard"}, "yard.map: no such file"},
        Case{{kept_, only_read}, {0, "save_map", "yard"}, "state.map is read_only"}})
    EXPECT_TRUE(has(told(asked.settings, {asked.command}), asked.answer)) << asked.answer;
  EXPECT_FALSE(fs::exists(folder_ / "state/ground.map"));
  const auto refused = told({}, {{0, reset, "bogus"}});
  EXPECT_TRUE(has(refused, "COMMAND: reset: expected no argument, or all"));
  EXPECT_FALSE(has(refused, "reset by command"));
}

TEST_F(RunnerTest, MapCommandsUseTheStateFolder) {
  const std::string longest(100, 'n');
  for (const std::string& name : {std::string("Yard-2.north_1"), longest}) {
    const auto all = told({kept_}, {{0, "save_map", name}, {0, "load_map", name}});
    EXPECT_TRUE(has(all, name + ".map: saved"));
    EXPECT_TRUE(has(all, "map " + name + " loaded"));
    EXPECT_TRUE(fs::exists(folder_ / ("state/" + name + ".map")));
  }
}

TEST_F(RunnerTest, MapNameCannotReachOtherFolders) {
  const std::string here = folder_ / "here";
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string(".hidden"),
        std::string("../outside"), std::string("below/it"), here, std::string("a b"),
        std::string("a\n"), std::string("a\0b", 3), std::string("\xc3\xa4"),
        std::string(101, 'n')}) {
    for (const char* command : {"save_map", "load_map"}) {
      const auto all = told({kept_}, {{0, command, name}});
      EXPECT_TRUE(has(all, std::string("COMMAND: ") + command + ": expected a map's name"))
          << command << " " << name;
    }
  }
  EXPECT_EQ(folder_.files(), std::set<std::string>{"state/lock"});  // what each run leaves
}

TEST_F(RunnerTest, LocateAtWantsFourFiguresAndPerhapsAMap) {
  for (const char* bad : {"", "1 2 3", "1 2 3 x", "1 2 3 0.5 x", "1 2 3 0.5 -1", "1 2 3 0.5 0 9",
                          "1,2,3,0.5", "1 2 3 0", "1 2 3 -1", "1 2 3 5", "nan 2 3 0.5"}) {
    EXPECT_TRUE(has(told({}, {{0, "locate_at", bad}}), "COMMAND: locate_at: expected ")) << bad;
  }
  for (const char* good : {"1 2 3 0.5", " -1.5e1 2 -3.1 0.5 0 "})
    EXPECT_FALSE(has(told({}, {{0, "locate_at", good}}), "locate_at: expected")) << good;
}

// Without a map nothing can be saved, and that is said: who asked must not wait for ever.
TEST_F(RunnerTest, MapCommandsAreRefusedWithoutAMap) {
  for (const char* off : {"graph.enabled=false", "gpr.enabled=false"}) {
    for (const char* command : {"save_map", "load_map"}) {
      const auto all = told({kept_, off}, {{0, command, "yard"}});
      EXPECT_TRUE(has(all, std::string("COMMAND: ") + command + ": ")) << command << " " << off;
      EXPECT_TRUE(has(all, "graph.enabled")) << command << " " << off;
    }
  }
  EXPECT_EQ(folder_.files(), std::set<std::string>{"state/lock"});
}

}  // namespace
}  // namespace gprodom
