#include "map/map_task.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <future>
#include <thread>

#include "map/map_frame.h"

namespace gprodom {
namespace {

// Savings of two files, of which the first is under way until later: the disk is slow.
class SlowSavings {
 public:
  explicit SlowSavings(MapTask& task) {
    task.save_ground(0, true, [this](const SavedGround& ground) {
      release_.get_future().wait();
      saved_.push_back(ground.bytes);
    });
    task.save_ground(0, true,
                     [this](const SavedGround& ground) { saved_.push_back(ground.bytes); });
    later_ = std::thread([this] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      release_.set_value();
    });
  }
  ~SlowSavings() { later_.join(); }
  std::size_t saved() const { return saved_.size(); }

 private:
  std::promise<void> release_;
  std::vector<std::string> saved_;
  std::thread later_;
};

TEST(MapTask, DestructorFinishesARequestedSaving) {
  auto task = std::make_unique<MapTask>(default_config(), Execution::kThreaded);
  const SlowSavings savings(*task);
  task.reset();
  EXPECT_EQ(savings.saved(), 2U);
}

TEST(MapTask, TakingTheGroundWaitsForTheSaving) {
  MapTask task(default_config(), Execution::kThreaded);
  const SlowSavings savings(task);
  task.take_ground();
  EXPECT_EQ(savings.saved(), 2U);
}

TEST(MapTask, SavedGroundWaitsForTheJobsBefore) {
  MapTask task(default_config(), Execution::kThreaded);
  const SlowSavings savings(task);
  EXPECT_FALSE(task.saved_ground().bytes.empty());
  EXPECT_EQ(savings.saved(), 2U);
}

// STATUS says how far the track has gone; a saving in between does not put that back to zero.
TEST(MapTask, AnswerToASavingSaysHowFarTheTrackHasGone) {
  MapTask task(default_config(), Execution::kInline);
  constexpr TimeNs kStep = 200'000'000, kSecond = 1'000'000'000;
  StateResult result;
  result.covariance.setIdentity();
  for (int i = 1; i <= 30; ++i) {
    result.state.time = i * kStep;
    result.state.p_odom = {0.1 * i, 0.0, 0.0};
    result.settled = result.state;
    task.add(result, result.state.time);
  }
  const TimeNs end = result.state.time + 10 * kSecond;
  double travelled_m = 0.0;
  while (const auto answer = task.next_due(end)) travelled_m = answer->travelled_m;
  ASSERT_GT(travelled_m, 2.0);
  task.save_ground(result.state.time, true, [](const SavedGround&) {});
  const auto answer = task.next_due(end);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->travelled_m, travelled_m);
}

// A robot with a wheel that reports kTrueScale of the distance, and that slips: it moves e^kSlip of
// what the wheel then turns. The graph knows both. The odometry does not see the slip, and has
// another scale. Its frame and that of the map differ.
class SlippingRobot {
 public:
  MapPose settled() const {
    MapPose pose;
    pose.in_odom.pose = kSettledInOdom;
    pose.in_odom.scale = kScaleInOdom;
    pose.in_odom.pose_covariance = 4e-4 * Eigen::Matrix3d::Identity();
    pose.in_map.pose = kSettledInMap;
    pose.in_map.scale = kTrueScale;
    pose.in_map.slip = kSlip;
    pose.in_map.covariance = 1e-4 * Matrix5d::Identity();
    pose.revisits = 3;
    return pose;
  }

  // Where the robot is in map after a way since the settled pose, given in the frame of that pose.
  static PlanarPose in_map(const PlanarPose& way) { return compose(kSettledInMap, way); }

  // Where the odometry has it then, which has added no error but that of slip and scale.
  static OdometryEstimate in_odom(const PlanarPose& way) {
    const double turned_by_wheel = std::exp(-kSlip) * kTrueScale;  // m reported for a true one
    const PlanarPose seen{turned_by_wheel / kScaleInOdom * way.p, way.yaw};
    const PlanarPose here = compose(kSettledInOdom, seen);
    OdometryEstimate estimate;
    estimate.time = 7;
    estimate.p_odom_body << here.p, 0.3;
    estimate.q_odom_body = Eigen::AngleAxisd(here.yaw, Eigen::Vector3d::UnitZ());
    set_planar_block(4e-4 * Eigen::Matrix3d::Identity(), estimate.pose_covariance);
    return estimate;
  }

 private:
  static constexpr double kTrueScale = 0.96, kScaleInOdom = 1.03, kSlip = -0.4;
  static inline const PlanarPose kSettledInOdom{{12.0, -5.0}, 0.7};
  static inline const PlanarPose kSettledInMap{{10.0, -8.0}, 1.1};
};

TEST(MapTask, CorrectionPutsTheRobotWhereItsTrueWaySinceThenEnds) {
  const SlippingRobot robot;
  const PlanarPose way{{3.0, 0.8}, 0.5};
  const OdometryEstimate now = robot.in_odom(way);
  const Correction correction = correction_by(robot.settled(), now);
  const Eigen::Vector3d placed = correction.q_map_odom * now.p_odom_body + correction.p_map_odom;
  EXPECT_LT((placed.head<2>() - robot.in_map(way).p).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(placed.z(), 0.3);  // height is odometry's
  const Eigen::Vector3d ahead = correction.q_map_odom * now.q_odom_body * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(std::atan2(ahead.y(), ahead.x()), robot.in_map(way).yaw, 1e-12);
  EXPECT_EQ(correction.time, now.time);
  EXPECT_EQ(correction.revisits, 3);
}

// What was driven up to the settled pose is in the graph's pose already.
TEST(MapTask, CorrectionOfARobotThatHasNotMovedSinceIsTheGraphsPose) {
  const SlippingRobot robot;
  const OdometryEstimate now = robot.in_odom({});
  const Correction correction = correction_by(robot.settled(), now);
  const Eigen::Vector3d placed = correction.q_map_odom * now.p_odom_body + correction.p_map_odom;
  EXPECT_LT((placed.head<2>() - robot.in_map({}).p).norm(), 1e-12);
  const Eigen::Matrix3d covariance = planar_block(correction.covariance);
  EXPECT_LT((covariance - 1e-4 * Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

}  // namespace
}  // namespace gprodom
