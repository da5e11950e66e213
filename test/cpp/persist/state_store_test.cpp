#include "persist/state_store.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "support/temporary_folder.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

class StateStoreTest : public ::testing::Test {
 protected:
  StateStoreTest() { config_.state.directory = folder_.path(); }

  template <class... Learnt>
  void keep(const Learnt&... learnt) {
    StateStore store(config_);
    store.save(learnt...);
    store.writer().flush();
    EXPECT_EQ(store.trouble(), "");
  }
  void save(double scale, double sigma, const std::optional<SavedState>& state = {}) {
    OdometryEstimate estimate;
    estimate.wheel_scale = scale;
    estimate.wheel_scale_sigma = sigma;
    keep(estimate, state);
  }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  // What a power cut, a failing disk or somebody else may make of a file.
  static std::vector<std::string> damaged(const std::string& whole) {
    std::string flipped = whole;
    flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 4);
    return {"",      "2.0 0.0001\n",     whole + "x", whole.substr(0, whole.size() / 2),
            flipped, whole.substr(0, 20)};
  }
  // That this is the only notice since it was asked last.
  void expect_notice(const std::string& part) {
    ASSERT_EQ(notices_.size(), 1u);
    EXPECT_NE(notices_[0].find(part), std::string::npos) << notices_[0];
    notices_.clear();
  }
  Config next_run() {
    notices_.clear();
    return StateStore(config_).config_with_wheel_scale(notices_);
  }

  TemporaryFolder folder_;
  Config config_;
  std::vector<std::string> notices_;
};

TEST_F(StateStoreTest, NextRunStartsFromTheSavedWheelScale) {
  EXPECT_EQ(next_run().wheel.scale, config_.wheel.scale);  // nothing was left
  save(0.97125, 0.004);
  const Config next = next_run();
  EXPECT_NEAR(next.wheel.scale, 0.97125, 1e-9);
  EXPECT_GT(next.wheel.scale_sigma, 0.004);
  EXPECT_LT(next.wheel.scale_sigma, 0.005);
  EXPECT_EQ(notices_.size(), 1u);
}

TEST_F(StateStoreTest, HeldOrBetterKnownScaleIsNotReplaced) {
  save(0.97, 0.004);
  config_.wheel.scale_sigma = 0;
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  config_.wheel.scale_sigma = 0.002;
  EXPECT_EQ(next_run().wheel.scale, 1.0);
}

TEST_F(StateStoreTest, DamagedWheelFileIsReportedAndNotUsed) {
  save(0.98, 0.004);
  for (const std::string& bytes : damaged(bytes_of(folder_ / "wheel.state"))) {
    write("wheel.state", bytes);
    EXPECT_EQ(next_run().wheel.scale, 1.0);
    EXPECT_EQ(notices_.size(), 1u);
  }
  for (const SavedWheel& wheel : {SavedWheel{NAN, 0.001, wheel_setting(config_)},
                                  SavedWheel{1.0, -0.001, wheel_setting(config_)}}) {
    write("wheel.state", to_bytes(wheel));
    EXPECT_EQ(next_run().wheel.scale_sigma, 0.02);
    EXPECT_EQ(notices_.size(), 1u);
  }
}

// Another figure or place in the configuration is another wheel, of which nothing was learnt.
TEST_F(StateStoreTest, SavedScaleOfAnotherWheelConfigurationIsDroppedWithANotice) {
  save(0.98, 0.004);
  const Config before = config_;
  const std::function<void(Config&)> changes[] = {
      [](Config& c) { c.wheel.scale = 1.0001; }, [](Config& c) { c.wheel.lever_arm.y() = 0.1; },
      [](Config& c) { c.channels.wheel = "LEFT"; }, [](Config& c) { c.channels.wheels = "REAR"; },
      [](Config& c) { c.wheel.form = WheelForm::kDistance; }};
  for (const auto& change : changes) {
    config_ = before;
    change(config_);
    const double configured = config_.wheel.scale;
    EXPECT_EQ(next_run().wheel.scale, configured);
    expect_notice("changed in the configuration since");
  }
  config_ = before;
  config_.imu.time_offset = 0.1;  // no matter of the wheel's
  EXPECT_NEAR(next_run().wheel.scale, 0.98, 1e-9);
}

TEST_F(StateStoreTest, SavedScaleFarFromTheConfiguredPriorIsDroppedWithANotice) {
  save(1.07, 0.004);  // 3.4 standard deviations of 0.0204
  EXPECT_NEAR(next_run().wheel.scale, 1.07, 1e-9);
  save(1.09, 0.004);  // 4.4
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  expect_notice("4 standard deviations off wheel.scale");
}

// A daemon that restarts at once goes on from its pose, but not with a scale that was edited away.
TEST_F(StateStoreTest, SavedPoseOfAnotherWheelGetsTheConfiguredScale) {
  SavedState state;
  state.noise = {1e-3, 1e-2};
  state.covariance *= 1e-4;
  state.state.wheel_scale = 0.98;
  save(0.98, 0.004, state);
  EXPECT_EQ(StateStore(config_).state(notices_)->state.wheel_scale, 0.98);
  config_.wheel.scale = 1.02;
  for (const double sigma : {0.02, 0.0}) {
    config_.wheel.scale_sigma = sigma;
    const auto back = StateStore(config_).state(notices_);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->state.wheel_scale, 1.02);
    EXPECT_NEAR(std::sqrt(back->covariance(row::kScale, row::kScale)), sigma, 1e-6);
    EXPECT_EQ(back->covariance(row::kP, row::kP), 1e-4);
  }
}

TEST_F(StateStoreTest, SlipIsKeptForTheSameWheel) {
  keep(slip::Learnt{{0.0, 0.0}, {-0.6, 0.2}});  // nothing was learnt
  EXPECT_FALSE(StateStore(config_).slip(notices_));
  keep(slip::Learnt{{100.0, 20.0}, {-0.6, 0.2}});
  const auto back = StateStore(config_).slip(notices_);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->counts.rolled_s, 100.0);
  EXPECT_EQ(back->counts.slipped_s, 20.0);
  EXPECT_EQ(back->position.y_m, -0.6);
  EXPECT_EQ(back->position.sigma_m, 0.2);
  EXPECT_TRUE(notices_.empty());
  config_.wheel.lever_arm.x() += 0.1;
  EXPECT_FALSE(StateStore(config_).slip(notices_));
  expect_notice("changed in the configuration since");
  for (const slip::Learnt& broken :
       {slip::Learnt{{100.0, 101.0}, {0.0, 0.5}}, slip::Learnt{{100.0, NAN}, {0.0, 0.5}},
        slip::Learnt{{INFINITY, 1.0}, {0.0, 0.5}}, slip::Learnt{{100.0, 20.0}, {NAN, 0.5}},
        slip::Learnt{{100.0, 20.0}, {0.0, -0.5}}}) {
    keep(broken);
    EXPECT_FALSE(StateStore(config_).slip(notices_));
    expect_notice("");
  }
}

TEST_F(StateStoreTest, AMountingIsKeptWhereItIsToBeFound) {
  const LearntMounting mounting{
      Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitY())), 0.03};
  keep(mounting);
  EXPECT_FALSE(StateStore(config_).mounting(notices_)) << "it is configured";
  config_.imu.rpy_body_imu.rpy.reset();
  const auto kept = StateStore(config_).mounting(notices_);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->q_body_imu.coeffs(), mounting.q_body_imu.coeffs());
  EXPECT_EQ(kept->yaw_sigma, mounting.yaw_sigma);
  EXPECT_TRUE(notices_.empty());
}

TEST_F(StateStoreTest, LearntPairIsKeptForTheSamePair) {
  config_.wheel.drive = WheelDrive::kSkidSteer;
  config_.wheel.track = 1.08;
  const auto next = [&] {
    notices_.clear();
    return StateStore(config_).pair(notices_);
  };
  EXPECT_FALSE(next());
  EXPECT_TRUE(notices_.empty());
  keep(LearntTurn{1.75, 0.05, -0.004, 0.002});
  const auto back = next();
  ASSERT_TRUE(back);
  EXPECT_EQ(back->track_m, 1.75);
  EXPECT_EQ(back->track_sigma_m, 0.05);
  EXPECT_EQ(back->radii_difference, -0.004);
  EXPECT_EQ(back->radii_difference_sigma, 0.002);
  expect_notice("1.7500 +- 0.0500");

  const Config before = config_;
  const std::function<void(Config&)> changes[] = {
      [](Config& c) { c.wheel.track = 1.0801; },
      [](Config& c) { c.wheel.drive = WheelDrive::kDifferential; },
      [](Config& c) { c.channels.wheels = "REAR"; }};
  for (const auto& change : changes) {
    config_ = before;
    change(config_);
    EXPECT_FALSE(next());
    expect_notice("changed in the configuration since");
  }
  config_ = before;
  config_.wheel.scale = 1.1;  // of the mean: the sides turn the robot as before
  EXPECT_TRUE(next());

  config_ = before;
  keep(LearntTurn{3.9, 0.05, 0.0, 0.002});  // 5 standard deviations off
  EXPECT_FALSE(next());
  expect_notice("3.900 m is 5 standard deviations off");
  for (const LearntTurn& broken : {LearntTurn{NAN, 0.05, 0, 0.002}, LearntTurn{1.75, 0, 0, 0.002},
                                   LearntTurn{1.75, 0.05, 0, INFINITY}}) {
    keep(broken);
    EXPECT_FALSE(next());
    EXPECT_EQ(notices_.size(), 1u);
  }
}

TEST_F(StateStoreTest, FolderInPlaceOfAFileIsReported) {
  for (const char* name : {"wheel.state", "wheels.state", "slip.state", "pose.state", "ground.map"})
    fs::create_directory(folder_ / name);
  EXPECT_EQ(next_run().wheel.scale, 1.0);
  StateStore store(config_);
  EXPECT_FALSE(store.state(notices_).has_value());
  EXPECT_FALSE(store.ground({}, notices_).has_value());
  EXPECT_FALSE(store.pair(notices_).has_value());
  EXPECT_FALSE(store.slip(notices_).has_value());
  ASSERT_EQ(notices_.size(), 5u);
  for (const std::string& notice : notices_)
    EXPECT_NE(notice.find(": cannot be read: it is a folder"), std::string::npos) << notice;
  OdometryEstimate estimate;
  estimate.wheel_scale_sigma = 0.01;
  store.save(estimate, {});
  store.writer().flush();
  store.take_notices();
  EXPECT_NE(store.trouble(), "");
}

TEST_F(StateStoreTest, SavedStateIsReadBackUnchanged) {
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
  const auto back = StateStore(config_).state(notices_);
  ASSERT_TRUE(back.has_value());
  EXPECT_TRUE(notices_.empty());
  state.wheel_setting = wheel_setting(config_);
  EXPECT_EQ(to_bytes(*back), to_bytes(state));
}

TEST_F(StateStoreTest, TruncatedOrDamagedStateIsReportedAndNotUsed) {
  SavedState state;
  state.noise = {1e-3, 1e-2};
  for (const std::string& bytes : damaged(to_bytes(state))) {
    write("pose.state", bytes);
    EXPECT_FALSE(StateStore(config_).state(notices_).has_value());
    expect_notice("");
  }
}

TEST_F(StateStoreTest, FolderThatCannotBeWrittenIsReportedWhileItLasts) {
  config_.state.directory = folder_ / "later";
  StateStore store(config_);
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
