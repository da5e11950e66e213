// The ground of earlier runs outlasts what happens to a run: traces of another setting, commands,
// failures, other users of its folder.
#include <gtest/gtest.h>

#include <exception>
#include <filesystem>
#include <functional>
#include <set>
#include <stdexcept>

#include "gprodom/error.h"
#include "gprodom/odometry.h"
#include "map/ground_map_file.h"
#include "map/map_task.h"
#include "pipeline/test_drive.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShorter = 100;  // samples

GprTrace shorter(GprTrace trace) {
  trace.samples.resize(kShorter);
  return trace;
}

class KeptGroundTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }
  Config config(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = more;
    all.push_back("state.directory=" + folder_.path().string());
    return default_config(all);
  }
  // Metres of stored ground.
  static double metres(const std::string& path) {
    std::vector<std::string> notices;
    const auto ground = read_ground_map(path, gpr::TraceMemoryOptions(), notices);
    EXPECT_TRUE(ground && notices.empty()) << path;
    return ground ? static_cast<double>(ground->memory.kept().size()) * ground->memory.spacing()
                  : 0.0;
  }
  std::set<std::string> maps() const {
    std::set<std::string> all;
    for (const std::string& name : folder_.files())
      if (fs::path(name).extension() == ".map") all.insert(name);
    return all;
  }

  // Each trace as `change` makes it, of its number. later_s: than the first drive.
  using Change = std::function<GprTrace(const GprTrace&, std::size_t)>;
  static std::vector<Input> drive(double later_s, const Change& change = {}) {
    std::vector<Input> inputs = later(there_and_back(3), later_s);
    std::size_t number = 0;
    for (Input& input : inputs)
      if (auto* trace = std::get_if<GprTrace>(&input))
        if (change) *trace = change(*trace, number++);
    return inputs;
  }

  void feed(Odometry& odometry, const std::vector<Input>& inputs) {
    for (const Input& input : inputs) {
      give(odometry, input);
      take(odometry.step());
    }
  }
  void take(const Outputs& out) {
    told_.insert(told_.end(), out.warnings.begin(), out.warnings.end());
    if (out.status.empty()) return;
    status_ = out.status.back();
  }
  void run(const std::vector<Input>& inputs, const std::vector<std::string>& more = {}) {
    told_.clear();
    Odometry odometry(config(more));
    feed(odometry, inputs);
    take(odometry.finish());
  }
  bool told(const std::string& part) const { return count_with(told_, part) > 0; }
  bool has_reason(const std::string& part) const { return count_with(status_.reasons, part) > 0; }

  TemporaryFolder folder_;
  std::vector<std::string> told_;
  Status status_;
};

TEST_F(KeptGroundTest, AFirstTraceOfAnotherLengthChangesNothing) {
  run(drive(0.0));
  const double before = metres(path("ground.map"));
  ASSERT_GT(before, 5.0);
  run(drive(1000.0, [](const GprTrace& trace, std::size_t number) {
    return number == 0 ? shorter(trace) : trace;
  }));
  EXPECT_GE(metres(path("ground.map")), before);
  EXPECT_EQ(maps(), std::set<std::string>{"ground.map"});
  EXPECT_FALSE(has_reason("map format"));
  EXPECT_TRUE(told("located on ground of an earlier track"));
}

TEST_F(KeptGroundTest, ALastingChangeOfTheRadarLeavesTheGroundUnderItsName) {
  run(drive(0.0));
  const std::string before = bytes_of(path("ground.map"));
  const auto all_shorter = [](const GprTrace& trace, std::size_t) { return shorter(trace); };
  run(drive(1000.0, all_shorter));
  EXPECT_TRUE(bytes_of(path("ground.map")) == before);
  ASSERT_EQ(maps().size(), 2U);
  const std::string other = path(*maps().begin());  // '-' sorts before '.'
  EXPECT_NE(other.find("ground-100x"), std::string::npos) << other;
  const double metres_of_other = metres(other);
  EXPECT_GT(metres_of_other, 5.0);
  EXPECT_TRUE(has_reason("map format: the radar sends 100 samples"));
  EXPECT_EQ(status_.health, HealthLevel::kDegraded);

  // The next run with that setting takes its ground up, and each with the first setting the first.
  run(drive(2000.0, all_shorter));
  EXPECT_TRUE(told("located on ground of an earlier track"));
  EXPECT_GE(metres(other), metres_of_other);
  EXPECT_TRUE(bytes_of(path("ground.map")) == before);
  run(drive(3000.0));
  EXPECT_TRUE(told("located on ground of an earlier track"));
  EXPECT_FALSE(has_reason("map format"));
  EXPECT_GE(metres(path("ground.map")), metres_of_other);
  EXPECT_EQ(maps().size(), 2U);
}

TEST_F(KeptGroundTest, ASettingThatWasTriedForAWhileLeavesTheGround) {
  for (const bool keeps : {true, false}) {
    run(drive(0.0));
    const double before = metres(path("ground.map"));
    Odometry odometry(config(keeps ? std::vector<std::string>{}
                                   : std::vector<std::string>{"state.map=read_only"}));
    told_.clear();
    feed(odometry, drive(1000.0, [](const GprTrace& trace, std::size_t number) {
           return number >= 100 && number < 200 ? shorter(trace) : trace;
         }));
    take(odometry.finish());
    EXPECT_TRUE(told("map format: the radar sends"));
    EXPECT_TRUE(told("map format: over"));
    EXPECT_GE(metres(path("ground.map")), before);
    EXPECT_FALSE(fs::exists(path("ground.kept-1.map")));
  }
}

TEST_F(KeptGroundTest, AMapOfAnotherSettingIsNotLoaded) {
  run(drive(0.0, [](const GprTrace& trace, std::size_t) { return shorter(trace); }));
  fs::rename(path("ground.map"), path("other.map"));
  Odometry odometry(config());
  feed(odometry, drive(1000.0));
  EXPECT_THROW(odometry.load_map(path("other.map")), FileError);
  take(odometry.finish());
  EXPECT_GT(metres(path("ground.map")), 5.0);
}

TEST_F(KeptGroundTest, ALoadedMapLeavesTheGroundDrivenOverOnDisk) {
  run(drive(0.0));
  fs::rename(path("ground.map"), path("yard.map"));
  const std::string yard = bytes_of(path("yard.map"));
  run(drive(1000.0));
  const double before = metres(path("ground.map"));
  {
    Odometry odometry(config());
    feed(odometry, standing(1.0, kDriveStart + from_seconds(2000.0)));
    odometry.load_map(path("yard.map"));
    feed(odometry, standing(1.0, kDriveStart + from_seconds(2001.0)));
    take(odometry.finish());
  }
  EXPECT_EQ(metres(path("ground.kept-1.map")), before);
  EXPECT_TRUE(bytes_of(path("ground.map")) == yard);
  EXPECT_TRUE(told("it is kept as ground.kept-1.map"));
}

TEST_F(KeptGroundTest, ForgottenGroundIsKeptUnderAnotherName) {
  run(drive(0.0));
  const double before = metres(path("ground.map"));
  Odometry odometry(config());
  feed(odometry, drive(1000.0));
  odometry.forget();
  EXPECT_FALSE(fs::exists(path("ground.map")));
  EXPECT_GE(metres(path("ground.kept-1.map")), before);
  feed(odometry, standing(2.0, kDriveStart + from_seconds(2000.0)));
  EXPECT_TRUE(has_reason("it is kept as ground.kept-1.map"));
  take(odometry.finish());
  EXPECT_TRUE(told("it is kept as ground.kept-1.map"));
  EXPECT_FALSE(fs::exists(path("ground.map")));
}

TEST_F(KeptGroundTest, AFolderHasOneUserOrSeveralThatOnlyRead) {
  run(drive(0.0));
  const std::vector<std::string> reads{"state.map=read_only"};
  {
    const Odometry user(config());
    EXPECT_THROW(Odometry{config()}, FileError);
    EXPECT_THROW(Odometry{config(reads)}, FileError);
  }
  const fs::file_time_type pose = fs::last_write_time(path("pose.state"));
  const Odometry reader(config(reads));
  EXPECT_THROW(Odometry{config()}, FileError);
  run(drive(1000.0), reads);  // a second one: it leaves the first one's pose alone
  EXPECT_TRUE(told("another user keeps pose, wheel and slip there"));
  EXPECT_EQ(fs::last_write_time(path("pose.state")), pose);
  EXPECT_TRUE(told("located on ground of an earlier track"));
}

TEST_F(KeptGroundTest, WhatIsNewIsSavedBetweenTheSavingsOfTheWhole) {
  run(drive(0.0));
  const std::string whole = bytes_of(path("ground.map"));
  const double before = metres(path("ground.map"));
  // Other ground, so that there is something new; the drive lasts 37 s, the whole is due in 300 s.
  Odometry odometry(config());
  feed(odometry, later(there_and_back(8), 1000.0));
  odometry.save_map(path("now.map"));  // waits for the savings before it
  EXPECT_TRUE(bytes_of(path("ground.map")) == whole);
  ASSERT_TRUE(fs::exists(path("ground.new")));
  // All but what was driven in the 10 s of state.save_period times 10.
  EXPECT_GT(metres(path("ground.map")), metres(path("now.map")) - 0.6 * 10.0);
  EXPECT_GT(metres(path("ground.map")), before + 3.0);
}

using RecoverTest = KeptGroundTest;
const std::exception_ptr kFrontEndFails =
    std::make_exception_ptr(std::runtime_error("a front end"));
const std::exception_ptr kMapFails = std::make_exception_ptr(MapFailure("map: a defect"));

TEST_F(RecoverTest, GroundOutlastsFailuresOfOthers) {
  run(drive(0.0));
  const double before = metres(path("ground.map"));
  told_.clear();
  Odometry odometry(config());
  for (int i = 0; i < 10; ++i) odometry.recover(kFrontEndFails);
  feed(odometry, drive(1000.0));
  odometry.recover(std::make_exception_ptr(7));
  take(odometry.finish());
  EXPECT_TRUE(told("located on ground of an earlier track"));
  EXPECT_GE(metres(path("ground.map")), before);
  EXPECT_EQ(maps(), std::set<std::string>{"ground.map"});
}

TEST_F(RecoverTest, GroundWithWhichTheMapFailsThreeTimesIsSetAside) {
  run(drive(0.0));
  const std::string before = bytes_of(path("ground.map"));
  Odometry odometry(config());
  for (int i = 0; i < 2; ++i) odometry.recover(kMapFails);
  EXPECT_TRUE(fs::exists(path("ground.map")));
  odometry.recover(kMapFails);
  EXPECT_FALSE(fs::exists(path("ground.map")));
  EXPECT_TRUE(bytes_of(path("ground.kept-1.map")) == before);
  feed(odometry, drive(1000.0));
  take(odometry.finish());
  EXPECT_TRUE(told("it is kept as ground.kept-1.map"));
  EXPECT_FALSE(told("located on ground of an earlier track"));
  EXPECT_GT(metres(path("ground.map")), 5.0);  // the new ground
}

TEST_F(RecoverTest, FailuresOfTheMapMinutesApartAreNoFaultOfTheGround) {
  run(drive(0.0));
  Odometry odometry(config());
  for (int i = 0; i < 5; ++i) {
    feed(odometry, standing(1.0, kDriveStart + from_seconds(1000.0 + 61.0 * i)));
    odometry.recover(kMapFails);
  }
  EXPECT_TRUE(fs::exists(path("ground.map")));
}

// What the run has learnt of the wheel is the prior of the restarted estimator.
TEST_F(RecoverTest, LearntWheelScaleIsKept) {
  Odometry odometry(config());
  double scale = 0.0, sigma = 0.0;
  const auto last = [&](const std::vector<Input>& inputs) {
    for (const Input& input : inputs) {
      if (!std::holds_alternative<GprTrace>(input)) give(odometry, input);
      const Outputs out = odometry.step();
      if (out.odometry.empty()) continue;
      scale = out.odometry.back().wheel_scale;
      sigma = out.odometry.back().wheel_scale_sigma;
    }
  };
  last(drive(0.0));
  const double learnt = scale, learnt_sigma = sigma;
  ASSERT_LT(learnt_sigma, 0.01);
  odometry.recover(kFrontEndFails);
  last(standing(4.0, kDriveStart + from_seconds(40.0)));
  EXPECT_NEAR(scale, learnt, 0.1 * learnt_sigma);
  EXPECT_LT(sigma, 1.1 * learnt_sigma);
}

// A pose that was saved in the map of a ground which is not on disk says nothing of the map there.
TEST_F(KeptGroundTest, APoseOfOtherGroundIsNoPlaceInThisOne) {
  run(drive(0.0));
  fs::rename(path("ground.map"), path("yard.map"));
  run(drive(1000.0));
  {
    Odometry odometry(config());
    feed(odometry, standing(4.0, kDriveStart + from_seconds(2000.0)));
    odometry.load_map(path("yard.map"));
    feed(odometry, standing(4.0, kDriveStart + from_seconds(2004.0)));  // the pose is saved
  }  // and the ground is not, as if it was killed
  Odometry odometry(config());
  feed(odometry, standing(4.0, kDriveStart + from_seconds(2009.0)));
  EXPECT_TRUE(told("resumed from the pose saved"));
  EXPECT_EQ(value_of(status_, "map.located"), 0.0);
}

}  // namespace
}  // namespace gprodom
