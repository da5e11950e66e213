#include "input/input_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "support/told.h"

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

ImuSample imu_at(TimeNs time, const Eigen::Vector3d& acceleration,
                 const Eigen::Vector3d& rate = Eigen::Vector3d::Zero()) {
  return {time, acceleration, rate};
}

class TwoAntennas : public ::testing::Test {
 protected:
  void use(const std::vector<std::string>& settings) {
    config_ = default_config(settings);
    check_.emplace(config_, health_);
  }
  bool accepts(InputMessage message) { return check_->accept(message); }
  // The IMU comes first: it is the clock.
  void start(TimeNs time) { ASSERT_TRUE(accepts(imu_at(time, {0, 0, 9.8}))); }
  double count(const std::string& what) {
    const Status status = health_.status(0);
    for (std::size_t i = 0; i < status.names.size(); ++i)
      if (status.names[i].find(what) != std::string::npos) return status.values[i];
    return 0.0;
  }

  const TimeNs begin_ = 1'700'000'000'000'000'000, period_ = 50'000'000;
  Config config_;
  Health health_{10.0};
  std::optional<InputCheck> check_;
};

TEST_F(TwoAntennas, TracesOfAnAntennaThatIsNotConfiguredAreRefusedAndCounted) {
  use({});
  start(begin_);
  EXPECT_TRUE(accepts(trace_of(3, begin_))) << "the first antenna that is heard is the antenna";
  EXPECT_FALSE(accepts(trace_of(4, begin_ + period_ / 2)));
  EXPECT_TRUE(accepts(trace_of(3, begin_ + period_)));
  EXPECT_EQ(check_->antenna(), 3);
  EXPECT_EQ(count("of a second antenna"), 1.0);
}

TEST_F(TwoAntennas, OnlyThoseOfTheConfigurationAreUsed) {
  use({"gpr.antennas={1: [0.1, 0, 0], 5: [-0.1, 0, 0]}"});
  EXPECT_EQ(config_.gpr.lever_arm.x(), 0.1) << "the first of them is the one that is followed";
  start(begin_);
  EXPECT_FALSE(accepts(trace_of(0, begin_)));
  EXPECT_TRUE(accepts(trace_of(5, begin_)));
  EXPECT_TRUE(accepts(trace_of(1, begin_))) << "channels of one radar have equal stamps";
  EXPECT_FALSE(accepts(trace_of(5, begin_))) << "stamp repeated";
  EXPECT_EQ(check_->antenna(), 1);
  EXPECT_EQ(count("not in gpr.antennas"), 1.0);
}

TEST_F(TwoAntennas, EachHasItsTimeOffset) {
  use({"gpr.antennas={0: [0.15, 0, 0], 1: [-0.15, 0, 0]}", "gpr.time_offset=0.002",
       "gpr.time_offsets={1: -0.004}"});
  start(begin_);
  InputMessage front = trace_of(0, begin_), rear = trace_of(1, begin_);
  ASSERT_TRUE(check_->accept(front));
  ASSERT_TRUE(check_->accept(rear));
  EXPECT_EQ(std::get<GprTrace>(front).time, begin_ + from_seconds(0.002)) << "that of all";
  EXPECT_EQ(std::get<GprTrace>(rear).time, begin_ - from_seconds(0.004)) << "its own";
}

// A robot that drives, stands for a minute and drives on, with a trace every 5 cm of its wheel.
class ByDistance : public TwoAntennas {
 protected:
  void drive(double seconds, double speed, bool radar = true) {
    for (int i = 0; i < static_cast<int>(100 * seconds); ++i, now_ += 10'000'000) {
      start(now_);
      way_m_ += 0.01 * speed;
      accepts(WheelSample{now_, way_m_});
      if (radar && way_m_ >= next_m_) {
        next_m_ += 0.05;
        EXPECT_TRUE(accepts(trace_of(sends_, now_)));
      }
      check_->watch_silence(true);
      if (check_->radar_silent()) ++silent_;
    }
  }
  auto reasons() { return count_with(health_.status(0).reasons, "GPR_TRACE: no data"); }

  TimeNs now_ = begin_;
  double way_m_ = 0.0, next_m_ = 0.05;
  int silent_ = 0, sends_ = 0;  // sends_: the antenna
};

TEST_F(ByDistance, NothingIsMissingWhileTheRobotStands) {
  for (const char* trigger : {"gpr.trigger=distance", "gpr.trigger=auto"}) {
    use({trigger});
    drive(5, 0.0);
    drive(10, 0.5);
    drive(60, 0.0);
    drive(10, 0.5);
    EXPECT_EQ(silent_, 0) << trigger;
    EXPECT_EQ(reasons(), 0);
    EXPECT_EQ(count("gap"), 0.0);
    EXPECT_EQ(check_->trigger(), Trigger::kDistance);
  }
}

TEST_F(ByDistance, ByTimeItWouldBe) {
  use({});
  drive(5, 0.5);
  drive(10, 0.0);
  EXPECT_GT(silent_, 800);
  EXPECT_EQ(reasons(), 1);
}

TEST_F(ByDistance, ARadarThatStopsWhileTheRobotDrivesIsTold) {
  use({"gpr.trigger=distance"});
  drive(5, 0.5);
  drive(3, 0.5, false);
  EXPECT_GT(silent_, 100);
  EXPECT_EQ(reasons(), 1);
}

TEST_F(ByDistance, WithoutAWheelSecondsCount) {
  use({"gpr.trigger=distance"});
  drive(5, 0.5);
  for (int i = 0; i < 300; ++i, now_ += 10'000'000) start(now_);
  EXPECT_TRUE(check_->radar_silent());
}

// The first antenna never sends. By time the other one would stand in after 3 s.
TEST_F(ByDistance, NoOtherAntennaStandsIn) {
  const auto followed = [this](const char* trigger) {
    use({trigger, "gpr.antennas={0: [0.15, 0, 0], 1: [-0.15, 0, 0]}"});
    sends_ = 1;
    drive(8, 0.5);
    return check_->followed();
  };
  EXPECT_EQ(followed("gpr.trigger=distance"), 0);
  EXPECT_EQ(followed("gpr.trigger=time"), 1);
}

// A gap of a second is bridged.
TEST_F(TwoAntennas, TheOtherOneIsFollowedWhileTheFirstIsGone) {
  use({"gpr.antennas={0: [0.15, 0, 0], 1: [-0.15, 0, 0]}"});
  const auto followed_after = [&](double from_s, double to_s, bool first_sends) {
    for (double t = from_s + 0.01; t < to_s; t += 0.05) {
      const TimeNs time = begin_ + from_seconds(t);
      // Noise: equal values are refused.
      const Eigen::Vector3d noise(0.01 * std::sin(70 * t), 0.01 * std::sin(50 * t), 0);
      EXPECT_TRUE(accepts(imu_at(time, noise + Eigen::Vector3d(0, 0, 9.8), noise)));
      EXPECT_EQ(first_sends && accepts(trace_of(0, time)), first_sends);
      EXPECT_TRUE(accepts(trace_of(1, time)));
    }
    check_->watch_silence(true);
    return check_->followed();
  };
  EXPECT_EQ(followed_after(0.0, 3.0, true), 0);
  EXPECT_EQ(followed_after(3.0, 5.0, false), 0);
  EXPECT_EQ(followed_after(5.0, 8.0, false), 1);
  EXPECT_FALSE(check_->radar_silent());
  EXPECT_EQ(check_->antenna(), 0) << "the map is of the first one";
  EXPECT_EQ(count_with(health_.status(begin_).reasons, "one antenna: the first one"), 1);
  EXPECT_EQ(followed_after(8.0, 9.0, true), 1) << "not at once";
  EXPECT_EQ(followed_after(9.0, 12.0, true), 0);
}

TEST(Health, EndOfAConditionIsReportedWithItsTextUnlessItWasAwaited) {
  using Warnings = std::vector<std::string>;
  Health health(10.0);
  health.set("WHEEL", HealthLevel::kDegraded, "no data for a second or more");
  EXPECT_EQ(health.take_warnings(), Warnings{"WHEEL: no data for a second or more"});
  EXPECT_EQ(health.status(1).reasons, Warnings{"WHEEL: no data for a second or more"});
  health.set("WHEEL", HealthLevel::kDegraded, "");
  EXPECT_EQ(health.take_warnings(), Warnings{"WHEEL: over: no data for a second or more"});
  EXPECT_TRUE(health.status(2).reasons.empty());
  health.await("start", HealthLevel::kDegraded, "collecting");
  health.set("start", HealthLevel::kDegraded, "");
  EXPECT_TRUE(health.take_warnings().empty());
}

// As in a tunnel. A receiver that sends nothing has no outage: fixes may be rare.
TEST(FixOutage, IsToldAfterASecondOfMessagesWithoutAPositionAndIsOverWithTheNext) {
  const Config config = default_config({});
  Health health{10.0};
  InputCheck check(config, health);
  const TimeNs begin = 1'700'000'000'000'000'000;
  int ticks = 0;  // of the IMU, the clock, 100 a second
  const auto told_after = [&](double seconds, FixQuality quality) {
    for (; ticks <= 100 * seconds; ++ticks) {
      InputMessage clock = imu_at(begin + ticks * 10'000'000L, {0, 0, 9.8 + 1e-3 * (ticks % 7)});
      EXPECT_TRUE(check.accept(clock));
    }
    PositionFix fix;
    fix.time = begin + from_seconds(seconds);
    fix.frame = FixFrame::kSite;
    fix.quality = quality;
    fix.covariance = Eigen::Matrix3d::Identity();
    InputMessage message = fix;
    EXPECT_EQ(check.accept(message), quality != FixQuality::kNone);
    check.watch_silence(false);
    const Status status = health.status(fix.time);
    return std::count(status.reasons.begin(), status.reasons.end(),
                      config.channels.position_fix + ": outage: no position for a second or more");
  };
  EXPECT_EQ(told_after(0.0, FixQuality::kFixed), 0);
  EXPECT_EQ(told_after(0.5, FixQuality::kNone), 0);
  EXPECT_EQ(told_after(1.0, FixQuality::kNone), 0);
  EXPECT_EQ(told_after(1.5, FixQuality::kNone), 1);
  EXPECT_EQ(told_after(2.0, FixQuality::kFixed), 0);
  EXPECT_EQ(told_after(2.5, FixQuality::kNone), 0);
}

}  // namespace
}  // namespace gprodom
