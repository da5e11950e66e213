// What one estimator leaves to the next: maps saved by command, and the pose to resume from.
#include "gprodom/odometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "gprodom/error.h"
#include "pipeline/test_drive.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

bool has(const Outputs& told, const std::string& part) {
  return count_with(told.warnings, part) > 0;
}

class OdometryTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  // Kept in the folder; pose, scale and ground are there for the next one.
  Config kept(const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> all = settings;
    all.push_back("state.directory=" + folder_.path().string());
    return default_config(all);
  }
  TemporaryFolder folder_;
};

constexpr int kSavings = 20;  // requested at once, so that some still wait at the next command

class MapSavedByCommand : public OdometryTest {
 protected:
  // The ground of a drive, and the pose at its end, in the folder.
  void SetUp() override {
    Odometry odometry(kept());
    drive_ = there_and_back(3);
    run(odometry, drive_);
    ground_ = bytes_of(path("ground.map"));
    ASSERT_GT(ground_.size(), 10000U);
  }

  // The file holds the ground at the time of the command, whatever comes after it.
  void expect_saved(const Config& config, const std::function<void(Odometry&)>& follow) {
    Odometry odometry(config, Execution::kThreaded);
    odometry.load_map(path("ground.map"));
    for (int i = 0; i < kSavings; ++i) odometry.begin_saving_map(name(i));
    follow(odometry);
    const Outputs told = run(odometry, standing(0.2, kDriveStart + from_seconds(40.0)));
    for (int i = 0; i < kSavings; ++i) {
      EXPECT_TRUE(has(told, name(i) + ": saved"));
      EXPECT_TRUE(bytes_of(name(i)) == ground_) << i;
    }
  }
  std::string name(int i) const { return path("saved" + std::to_string(i) + ".map"); }

  std::vector<Input> drive_;
  std::string ground_;
};

TEST_F(MapSavedByCommand, IsThatOfItsTimeWhateverFollows) {
  const Config config = default_config();
  expect_saved(config, [this](Odometry& o) { o.load_map(path("ground.map")); });  // or another
  expect_saved(config, [this](Odometry& o) { o.load_map(name(kSavings - 1)); });
  expect_saved(config, [](Odometry& o) { o.forget(); });
  expect_saved(config, [](Odometry& o) { o.reset(); });
  expect_saved(kept(), [](Odometry&) {});  // the first data make it go on from the saved pose
}

TEST_F(OdometryTest, SavingIsRefusedWithoutAMap) {
  for (const char* off : {"graph.enabled=false", "gpr.enabled=false"})
    EXPECT_THROW(Odometry(default_config({off})).save_map(path("other.map")), FileError);
  EXPECT_FALSE(fs::exists(path("other.map")));
}

// state.resume_within: the age of the saved pose, at the first data, up to which it is gone on
// from. That of the last state in effect is some tenths of a second at the end of the run.
class ResumeTest : public OdometryTest {
 protected:
  void SetUp() override {
    Odometry odometry(kept());
    const Outputs told = run(odometry, standing(5.0));
    ASSERT_FALSE(told.odometry.empty());
    end_ = told.odometry.back().time;
  }
  Outputs after(double pause_s, const std::vector<std::string>& settings) {
    Odometry odometry(kept(settings));
    start_ = end_ + from_seconds(pause_s);
    return run(odometry, standing(5.0, start_));
  }
  static double first_pose(const Outputs& told, TimeNs since) {
    return to_seconds(told.odometry.front().time - since);
  }

  TimeNs end_ = 0, start_ = 0;
};

TEST_F(ResumeTest, ResumesFromARecentPose) {
  const Outputs told = after(2.0, {"state.resume_within=4"});
  EXPECT_TRUE(has(told, "resumed from the pose saved"));
  EXPECT_LT(first_pose(told, start_), 1.0);
}

// A wheel may have slipped unseen before the run ended: that is not known better after it.
TEST_F(ResumeTest, IsNoSurerOfThePoseThanTheRunBefore) {
  const auto variance = [](const OdometryEstimate& estimate) {
    return estimate.pose_covariance.topLeftCorner<2, 2>().trace();
  };
  std::vector<Input> drive = there_and_back(1);
  drive.resize(drive.size() / 3);  // it ends on the way
  OdometryEstimate last;
  {
    Odometry before(kept());
    last = run(before, drive).odometry.back();
  }
  Odometry resumed(kept());
  const Outputs told = run(resumed, standing(3.0, last.time + from_seconds(0.5)));
  ASSERT_TRUE(has(told, "resumed from the pose saved"));
  EXPECT_GT(variance(told.odometry.front()), 0.9 * variance(last));
  EXPECT_GT(variance(last), 1e-4);
}

// The scale that gravity has shown holds on: in the next run, and after a reset.
TEST_F(ResumeTest, TakesOverTheScaleOfTheAccelerometer) {
  const auto measured = [](double seconds, TimeNs start) {
    std::vector<Input> inputs = standing(seconds, start);
    for (Input& input : inputs)
      if (auto* imu = std::get_if<ImuSample>(&input)) imu->acceleration *= 0.8;
    return inputs;
  };
  TimeNs end = 0;
  {
    Odometry before(kept());
    end = run(before, measured(5.0, end_ + from_seconds(60.0))).odometry.back().time;
  }
  Odometry resumed(kept());
  const Outputs told = run(resumed, measured(5.0, end + from_seconds(1.0)));
  ASSERT_TRUE(has(told, "resumed from the pose saved"));
  EXPECT_TRUE(has(told, "its specific force is 80 % of gravity"));
  EXPECT_LT(told.odometry.back().v_body.norm(), 0.01);
  EXPECT_LT(told.odometry.back().accel_bias.norm(), 0.05);
  resumed.reset();
  const Outputs again = run(resumed, measured(5.0, told.odometry.back().time + from_seconds(1.0)));
  ASSERT_FALSE(again.odometry.empty());
  EXPECT_TRUE(has(again, "its specific force is 80 % of gravity"));
}

TEST_F(ResumeTest, DoesNotResumeFromAnExpiredPose) {
  const Outputs told = after(4.0, {"state.resume_within=4"});
  EXPECT_TRUE(has(told, "s old (state.resume_within): starting at the initialiser"));
  EXPECT_GT(first_pose(told, start_), 0.9 * InitializerConfig().duration);
  EXPECT_FALSE(has(told, "resumed"));
}

TEST_F(ResumeTest, DoesNotResumeIfThatIsTurnedOffOrFromAPoseInTheFuture) {
  EXPECT_FALSE(has(after(0.1, {"state.resume_within=0"}), "resumed"));
  EXPECT_FALSE(has(after(-20.0, {}), "resumed"));  // the clock was set back meanwhile
}

// The clock is set ahead by an hour in mid-drive. If all sensors step, `odom` continues with the
// new stamps; if the IMU steps alone, with those of the others.
TEST(ClockStepTest, OdomContinuesWhenOneClockStepsOrAllTogether) {
  const Config config = default_config();
  const std::vector<Input> inputs = there_and_back(1);
  Odometry whole(config);
  const OdometryEstimate end = run(whole, inputs).odometry.back();
  const TimeNs hour = from_seconds(3600.0);
  const auto stepped = [&](bool all) {
    std::vector<Input> stepped = inputs;
    for (Input& input : stepped)
      if (time_of(input) > kDriveStart + from_seconds(10.0) &&
          (all || std::holds_alternative<ImuSample>(input)))
        input = later({input}, 3600.0).front();
    Odometry odometry(config);
    odometry.record();
    Outputs told = run(odometry, stepped);
    if (all) {
      EXPECT_NEAR(to_seconds(odometry.recorded().back().time - end.time), 3600.0, 1.0);
    }
    return told;
  };
  const Outputs told = stepped(true);
  EXPECT_TRUE(has(told, "IMU: clock was set ahead with those of all sensors"));
  EXPECT_FALSE(has(told, "the estimator restarts"));
  EXPECT_EQ(told.odometry.back().time, end.time + hour);
  EXPECT_LT((told.odometry.back().p_odom_body - end.p_odom_body).norm(), 0.15);
  TimeNs largest_gap = 0;
  for (std::size_t i = 1; i < told.odometry.size(); ++i) {
    ASSERT_GT(told.odometry[i].time, told.odometry[i - 1].time);
    const TimeNs gap = told.odometry[i].time - told.odometry[i - 1].time;
    if (gap < hour) largest_gap = std::max(largest_gap, gap);
  }
  EXPECT_LT(largest_gap, from_seconds(0.5));
  const Outputs alone = stepped(false);
  EXPECT_TRUE(has(alone, "IMU: clock was set alone"));
  EXPECT_FALSE(has(alone, "the estimator restarts"));
  EXPECT_EQ(alone.odometry.back().time, end.time);
  EXPECT_LT((alone.odometry.back().p_odom_body - end.p_odom_body).norm(), 0.15);
}

// Of a robot whose IMU is silent from 8 s to 10 s, while it drives 1.2 m.
TEST(DistanceTest, DistanceDrivenInAnImuGapIsCounted) {
  const Config config = default_config();
  std::vector<Input> inputs = there_and_back(1);
  Odometry whole(config);
  const double driven_m = run(whole, inputs).odometry.back().distance_m;
  const auto silent = [](const Input& input) {
    const auto* imu = std::get_if<ImuSample>(&input);
    const double t = imu ? to_seconds(imu->time - kDriveStart) : 0.0;
    return t > 8.0 && t < 10.0;
  };
  inputs.erase(std::remove_if(inputs.begin(), inputs.end(), silent), inputs.end());
  Odometry with_gap(config);
  EXPECT_NEAR(run(with_gap, inputs).odometry.back().distance_m, driven_m, 0.3);
}

}  // namespace
}  // namespace gprodom
