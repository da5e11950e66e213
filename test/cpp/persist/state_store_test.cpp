#include "persist/state_store.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace gprodom {
namespace {

namespace fs = std::filesystem;

class StateStoreTest : public ::testing::Test {
 protected:
  StateStoreTest() {
    std::string pattern = (fs::temp_directory_path() / "gprodom-state-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
    config_.state.directory = folder_.string();
  }
  ~StateStoreTest() override { fs::remove_all(folder_); }

  void save(double scale, double sigma, const std::optional<SavedState>& state = {}) {
    StateStore store(config_.state);
    OdometryEstimate estimate;
    estimate.wheel_scale = scale;
    estimate.wheel_scale_sigma = sigma;
    store.save(estimate, state);
    store.writer().flush();
    EXPECT_EQ(store.trouble(), "");
  }
  Config next_run() {
    notices_.clear();
    return StateStore(config_.state).with_wheel_scale(config_, notices_);
  }

  fs::path folder_;
  Config config_;
  std::vector<std::string> notices_;
};

TEST_F(StateStoreTest, TheNextRunStartsFromThisOnes) {
  EXPECT_EQ(next_run().wheel.scale, config_.wheel.scale);  // nothing was left
  save(0.97125, 0.004);
  const Config next = next_run();
  EXPECT_NEAR(next.wheel.scale, 0.97125, 1e-9);
  EXPECT_GT(next.wheel.scale_sigma, 0.004);
  EXPECT_LT(next.wheel.scale_sigma, 0.005);
  EXPECT_EQ(notices_.size(), 1u);
}

TEST_F(StateStoreTest, WhatIsHeldOrBetterKnownStays) {
  save(0.97, 0.004);
  config_.wheel.scale_sigma = 0;
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  config_.wheel.scale_sigma = 0.002;
  EXPECT_EQ(next_run().wheel.scale, 1.0);
}

TEST_F(StateStoreTest, ABrokenFileIsTold) {
  std::ofstream(folder_ / "wheel_scale.txt") << "nan 0.1";
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  EXPECT_EQ(notices_.size(), 1u);
}

TEST_F(StateStoreTest, AFolderInAFilesPlaceIsTold) {
  for (const char* name : {"wheel_scale.txt", "pose.state", "ground.map"})
    fs::create_directory(folder_ / name);
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  StateStore store(config_.state);
  EXPECT_FALSE(store.state(notices_).has_value());
  EXPECT_FALSE(store.ground({}, notices_).has_value());
  ASSERT_EQ(notices_.size(), 3u);
  for (const std::string& notice : notices_)
    EXPECT_NE(notice.find(": cannot be read: it is a folder"), std::string::npos) << notice;
  OdometryEstimate estimate;
  estimate.wheel_scale_sigma = 0.01;
  store.save(estimate, {});
  store.writer().flush();
  store.take_notices();
  EXPECT_NE(store.trouble(), "");
}

TEST_F(StateStoreTest, TheStateComesBackAsItWas) {
  SavedState state;
  state.state.time = 123456789;
  state.state.p_odom = {1.0, -2.0, 0.5};
  state.state.q_odom_body = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  state.covariance *= 1e-3;
  state.noise = {1e-3, 1e-2};
  state.wheel_m = 12.5;
  state.correction.emplace();
  state.correction->p_map_odom.x() = 3.0;
  state.map = 2;
  save(1.0, 0.01, state);
  const auto back = StateStore(config_.state).state(notices_);
  ASSERT_TRUE(back.has_value());
  EXPECT_TRUE(notices_.empty());
  EXPECT_EQ(to_bytes(*back), to_bytes(state));
}

TEST_F(StateStoreTest, AStateThatIsCutOffOrDamagedIsToldAndNotUsed) {
  SavedState state;
  state.noise = {1e-3, 1e-2};
  const std::string whole = to_bytes(state);
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 4);
  for (const std::string& bytes : {whole.substr(0, whole.size() / 2), flipped, std::string(),
                                   whole + "x", whole.substr(0, 20)}) {
    std::ofstream(folder_ / "pose.state", std::ios::binary) << bytes;
    notices_.clear();
    EXPECT_FALSE(StateStore(config_.state).state(notices_).has_value());
    EXPECT_EQ(notices_.size(), 1u);
  }
}

TEST_F(StateStoreTest, AFolderThatCannotBeWrittenIsToldForAsLongAsItLasts) {
  config_.state.directory = (folder_ / "later").string();
  StateStore store(config_.state);
  OdometryEstimate estimate;
  estimate.wheel_scale_sigma = 0.01;
  const auto trouble = [&] {
    store.save(estimate, {});
    store.writer().flush();
    store.take_notices();
    return store.trouble();
  };
  EXPECT_NE(trouble(), "");
  EXPECT_NE(trouble(), "");
  fs::create_directory(folder_ / "later");
  EXPECT_EQ(trouble(), "");
}

}  // namespace
}  // namespace gprodom
