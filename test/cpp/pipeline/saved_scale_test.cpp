#include "pipeline/saved_scale.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace gprodom {
namespace {

namespace fs = std::filesystem;

class SavedScaleTest : public ::testing::Test {
 protected:
  SavedScaleTest() {
    std::string pattern = (fs::temp_directory_path() / "gprodom-scale-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
    config_.state.directory = folder_.string();
  }
  ~SavedScaleTest() override { fs::remove_all(folder_); }

  void save(double scale, double sigma) {
    SavedScale saved(config_.state);
    OdometryEstimate estimate;
    estimate.wheel_scale = scale;
    estimate.wheel_scale_sigma = sigma;
    for (const TimeNs time : {from_seconds(1), from_seconds(12)}) {
      estimate.time = time;
      EXPECT_EQ(saved.save(estimate), "");
    }
  }
  Config next_run() {
    notices_.clear();
    return SavedScale(config_.state).taken_up(config_, notices_);
  }

  fs::path folder_;
  Config config_;
  std::vector<std::string> notices_;
};

TEST_F(SavedScaleTest, TheNextRunStartsFromThisOnes) {
  EXPECT_EQ(next_run().wheel.scale, config_.wheel.scale);  // nothing was left
  save(0.97125, 0.004);
  const Config next = next_run();
  EXPECT_NEAR(next.wheel.scale, 0.97125, 1e-9);
  EXPECT_GT(next.wheel.scale_sigma, 0.004);
  EXPECT_LT(next.wheel.scale_sigma, 0.005);
  EXPECT_EQ(notices_.size(), 1u);
}

TEST_F(SavedScaleTest, WhatIsHeldOrBetterKnownStays) {
  save(0.97, 0.004);
  config_.wheel.scale_sigma = 0;
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  config_.wheel.scale_sigma = 0.002;
  EXPECT_EQ(next_run().wheel.scale, 1.0);
}

TEST_F(SavedScaleTest, ABrokenFileIsTold) {
  std::ofstream(folder_ / "wheel_scale.txt") << "nan 0.1";
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  EXPECT_EQ(notices_.size(), 1u);
}

TEST_F(SavedScaleTest, AFolderThatCannotBeWrittenIsToldOnce) {
  config_.state.directory = (folder_ / "missing").string();
  SavedScale saved(config_.state);
  OdometryEstimate estimate;
  estimate.wheel_scale_sigma = 0.01;
  int told = 0;
  for (int second = 1; second < 60; ++second) {
    estimate.time = from_seconds(second);
    told += saved.save(estimate).empty() ? 0 : 1;
  }
  EXPECT_EQ(told, 1);
}

}  // namespace
}  // namespace gprodom
