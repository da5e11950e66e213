#include "map/map_task.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <future>
#include <thread>

#include "estimation/graph/pose_graph.h"
#include "map/map_frame.h"
#include "support/noise.h"

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

// What was driven up to the settled pose is in the graph's pose already.
TEST(MapTask, CorrectionPutsTheRobotWhereItsTrueWaySinceThenEnds) {
  const SlippingRobot robot;
  for (const PlanarPose& way : {PlanarPose{{3.0, 0.8}, 0.5}, PlanarPose()}) {
    const OdometryEstimate now = robot.in_odom(way);
    const Correction correction = correction_by(robot.settled(), now);
    const Eigen::Vector3d placed = correction.q_map_odom * now.p_odom_body + correction.p_map_odom;
    EXPECT_LT((placed.head<2>() - robot.in_map(way).p).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(placed.z(), 0.3);  // height is odometry's
    const Eigen::Vector3d ahead =
        correction.q_map_odom * now.q_odom_body * Eigen::Vector3d::UnitX();
    EXPECT_NEAR(std::atan2(ahead.y(), ahead.x()), robot.in_map(way).yaw, 1e-12);
    EXPECT_EQ(correction.time, now.time);
    EXPECT_EQ(correction.revisits, 3);
    const Eigen::Matrix3d more =
        planar_block(correction.covariance) - 1e-4 * Eigen::Matrix3d::Identity();
    EXPECT_EQ(more.norm() < 1e-12, way.p.isZero());
  }
}

Eigen::Quaterniond yaw(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

OdometryEstimate estimate_at(TimeNs time) {
  OdometryEstimate estimate;
  estimate.time = time;
  estimate.p_odom_body = {1, 0, 0};
  return estimate;
}

Correction correction_at(TimeNs time, double x) {
  Correction correction;
  correction.time = time;
  correction.p_map_odom = {x, 0, 0};
  correction.q_map_odom = yaw(M_PI / 2);
  return correction;
}

TEST(MapFrame, CorrectionIsInForceFromItsTimeOn) {
  MapFrame frame;
  Outputs outputs;
  outputs.odometry = {estimate_at(10), estimate_at(20), estimate_at(30)};
  outputs.corrections = {correction_at(20, 5), correction_at(45, 7)};
  const auto first = frame.place(outputs);
  EXPECT_EQ(first[0].p_odom_body, Eigen::Vector3d(1, 0, 0));
  EXPECT_LT((first[1].p_odom_body - Eigen::Vector3d(5, 1, 0)).norm(), 1e-15);
  EXPECT_LT(first[2].q_odom_body.angularDistance(yaw(M_PI / 2)), 1e-15);

  outputs.corrections.clear();
  outputs.odometry = {estimate_at(40), estimate_at(50)};
  const auto second = frame.place(outputs);
  EXPECT_NEAR(second[0].p_odom_body.x(), 5, 1e-15);
  EXPECT_NEAR(second[1].p_odom_body.x(), 7, 1e-15);

  frame.reset();
  EXPECT_EQ(frame.place(outputs)[0].p_odom_body, Eigen::Vector3d(1, 0, 0));
}

// Covariance against sampled errors, exactly composed: an odometry with an error where the
// correction was made (which the correction takes back), and one that it has added since; a map
// with an error of its own at that place.
TEST(MapFrame, CovarianceMatchesSampledErrors) {
  Noise normal(7);
  const auto draw = [&](const Eigen::Matrix3d& root) -> Eigen::Vector3d {
    const Eigen::Vector3d e(normal(), normal(), normal());
    return root * e;
  };
  Eigen::Matrix3d root_before, root_added, root_map;
  for (Eigen::Matrix3d* root : {&root_before, &root_added, &root_map}) {
    *root = 0.003 * Eigen::Matrix3d::NullaryExpr([&] { return normal(); });
  }
  const PlanarPose since{{3, -2}, 0.4}, step{{1.5, 0.7}, 0.8};
  const PlanarPose here = compose(since, step), origin_in_map{{5, 1}, 1.1};

  // Errors of a pose add to it in the axes of its frame.
  const auto disturbed = [](PlanarPose pose, const Eigen::Vector3d& e) {
    pose.p += e.head<2>();
    pose.yaw += e[2];
    return pose;
  };
  constexpr int kSamples = 20000;
  Eigen::Matrix3d odom = Eigen::Matrix3d::Zero(), map = Eigen::Matrix3d::Zero();
  for (int n = 0; n < kSamples; ++n) {
    const PlanarPose seen_since = disturbed(since, draw(root_before));
    const PlanarPose seen_here = compose(seen_since, disturbed(step, draw(root_added)));
    const PlanarPose map_since = disturbed(compose(origin_in_map, since), draw(root_map));
    const PlanarPose map_here = compose(map_since, between(seen_since, seen_here));
    const PlanarPose true_here = compose(origin_in_map, here);
    Eigen::Vector3d e, m;
    e << seen_here.p - here.p, seen_here.yaw - here.yaw;
    m << map_here.p - true_here.p, std::remainder(map_here.yaw - true_here.yaw, 2 * M_PI);
    odom += e * e.transpose() / kSamples;
    map += m * m.transpose() / kSamples;
  }

  const auto estimate = [](const PlanarPose& pose, const Eigen::Matrix3d& covariance) {
    OdometryEstimate x;
    x.p_odom_body << pose.p, 0.0;
    set_planar_block(covariance, x.pose_covariance);
    return x;
  };
  Correction correction;
  correction.q_map_odom = yaw(origin_in_map.yaw);
  correction.p_map_odom << origin_in_map.p, 0.0;
  const Eigen::Matrix3d carried = carried_covariance(
      correction, root_map * root_map.transpose(),
      estimate(since, root_before * root_before.transpose()), estimate(here, odom));
  // Sampling leaves about sqrt(2 / kSamples) = 1 %.
  EXPECT_LT((carried - map).norm(), 0.05 * map.norm());
}

// What is told of a pose that the correction was made for is the correction's own covariance.
TEST(MapFrame, CovarianceAtTheCorrectionIsThatOfTheCorrection) {
  MapFrame frame;
  Outputs outputs;
  outputs.odometry = {estimate_at(20)};
  outputs.odometry[0].pose_covariance = 4e-4 * Matrix6d::Identity();
  outputs.corrections = {correction_at(20, 5)};
  outputs.corrections[0].covariance = 1e-4 * Matrix6d::Identity();
  const Matrix6d covariance = frame.place(outputs)[0].pose_covariance;
  Matrix6d expected = 4e-4 * Matrix6d::Identity();  // height, roll and pitch are odometry's
  set_planar_block(1e-4 * Eigen::Matrix3d::Identity(), expected);
  EXPECT_LT((covariance - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace gprodom
