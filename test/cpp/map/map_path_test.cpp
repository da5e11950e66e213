#include "map/path/map_path.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "map/straight_robot.h"

namespace gprodom {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kScaleSigma = 0.01;
constexpr TimeNs kInterval = 200'000'000;

// A reference estimator: dead reckoning in the plane over steps with known noise and unknown scale.
// Its statements on each state are exact, so the result of the path can be compared with
// samples.
class Path {
 public:
  void step(double forward, double turn) {
    const double noise = 0.002, yaw_noise = 0.001;
    const PlanarPose before = pose_;
    pose_ = compose(pose_, {{forward, 0.0}, turn});
    // Errors that turn and shift odom: (x, y, yaw). A step's error, seen there.
    Matrix3d into_odom = Matrix3d::Identity();
    into_odom.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(before.yaw).toRotationMatrix();
    Matrix3d from_pose = Matrix3d::Identity();
    from_pose(0, 2) = pose_.p.y();
    from_pose(1, 2) = -pose_.p.x();
    const Matrix3d M = from_pose * into_odom;
    const Matrix3d Q = Vector3d(noise * noise, noise * noise, yaw_noise * yaw_noise).asDiagonal();
    d_scale_ += M * Vector3d(-forward, 0, 0);  // reported distance d, true d / s, s near 1
    covariance_ += M * Q * M.transpose();
  }

  StateResult result(TimeNs time) const {
    StateResult result;
    result.state.time = time;
    result.state.p_odom << pose_.p, 0.0;
    result.state.q_odom_body = Eigen::AngleAxisd(pose_.yaw, Vector3d::UnitZ());
    const int rows[] = {row::kP, row::kP + 1, row::kTheta + 2};
    const double variance = kScaleSigma * kScaleSigma;
    const Matrix3d all = covariance_ + variance * d_scale_ * d_scale_.transpose();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) result.covariance(rows[i], rows[j]) = all(i, j);
      result.covariance(rows[i], row::kScale) = variance * d_scale_[i];
      result.covariance(row::kScale, rows[i]) = variance * d_scale_[i];
    }
    result.covariance(row::kScale, row::kScale) = variance;
    return result;
  }

 private:
  PlanarPose pose_;
  Vector3d d_scale_ = Vector3d::Zero();
  Matrix3d covariance_ = Matrix3d::Identity() * 1e-6;
};

// What the estimator said of a step comes back: its noise, and what the scale has to do with it,
// far from the origin and turned.
TEST(MapPath, StepsAreThoseOfTheEstimator) {
  Path path;
  for (int i = 0; i < 50; ++i) path.step(0.4, 0.05);
  const PathState a = path_state(path.result(1));
  path.step(0.5, 0.3);
  const PlanarStep step = step_between(a, path_state(path.result(2)));
  EXPECT_LT((step.measured.p - Eigen::Vector2d(0.5, 0.0)).norm(), 1e-9);
  EXPECT_NEAR(step.measured.yaw, 0.3, 1e-9);
  EXPECT_LT((step.d_scale - Vector3d(-0.5, 0.0, 0.0)).norm(), 1e-9);
  const Matrix3d expected = Vector3d(4e-6, 4e-6, 1e-6).asDiagonal();
  EXPECT_LT((step.covariance - expected).norm(), 1e-3 * expected.norm());
}

// A scale that is believed anew moves the whole of odom with it. The step between two states told
// with different scales is that of the second.
TEST(MapPath, RevisedScaleIsNotTakenForMotion) {
  Path path;
  for (int i = 0; i < 100; ++i) path.step(0.2, 0.0);
  PathState a = path_state(path.result(1));
  path.step(0.2, 0.0);
  PathState b = path_state(path.result(2));
  b.scale += 0.005;  // as if told after the scale was revised: 20.2 m shrink
  b.pose.p += b.d_scale.head<2>() * 0.005;
  const PlanarStep step = step_between(a, b);
  EXPECT_NEAR(step.measured.p.x(), 0.2 * (1 - 0.005), 1e-9);
}

// A bias of the gyro that is learnt at a standstill turns all that was driven, and odom jumps with
// it. The robot has not moved: each state follows the one before as one solution has both.
TEST(MapPath, WhatIsLearntOfThePastIsNoMotion) {
  const PlanarPose turned{{0.08, -0.05}, 0.02};  // of odom, between two solutions
  const auto nav_state = [](TimeNs time, const PlanarPose& pose) {
    NavState state;
    state.time = time;
    state.p_odom << pose.p, 0.0;
    state.q_odom_body = Eigen::AngleAxisd(pose.yaw, Vector3d::UnitZ());
    return state;
  };
  Path path;
  for (int i = 0; i < 100; ++i) path.step(0.2, 0.01);
  PathState a = path_state(path.result(1));
  const PlanarPose first = a.pose;
  path.step(0.2, 0.01);
  PathState b = path_state(path.result(2));
  StateResult later = path.result(3);
  later.state.wheel_scale = a.scale;
  later.before_settled = nav_state(1, compose(turned, first));
  later.settled = nav_state(2, compose(turned, b.pose));
  settle(b, later, a);
  EXPECT_LT((b.pose.p - later.settled->p_odom.head<2>()).norm(), 1e-12);
  const PlanarPose step = step_between(a, b).measured;
  EXPECT_NEAR(step.p.x(), 0.2, 1e-9);
  EXPECT_NEAR(step.p.y(), 0.0, 1e-9);
  EXPECT_NEAR(step.yaw, 0.01, 1e-9);
  // Where the earlier state lies now.
  EXPECT_LT((seen_from(b, a).pose.p - compose(turned, first).p).norm(), 1e-9);
}

// Antennas in a row tell of a distance seconds later.
TEST(MapPath, ASettledStateHasTheSlipThatAntennasHaveLeft) {
  Path path;
  path.step(0.2, 0.0);
  StateResult result = path.result(1);
  result.slip_sigma = 0.1;
  result.unmeasured_slip_sigma = 0.2;
  const auto settled = [&](std::optional<double> by_pair) {
    PathState state = path_state(result);
    StateResult later = result;
    later.settled = result.state;
    later.settled_slip_by_pair = by_pair;
    settle(state, later);
    return state.slip_sigma;
  };
  EXPECT_EQ(settled(std::nullopt), 0.1);
  EXPECT_EQ(settled(0.0), 0.0);
  EXPECT_EQ(settled(0.15), 0.15);
  EXPECT_EQ(settled(INFINITY), 0.2);
}

TEST(MapPath, PlacesBetweenNodesLieOnTheArc) {
  MapPath path(0.5);
  const double radius = 3.0;
  const auto state_at = [&](int i) {
    PathState state;
    const double angle = 0.1 * i / radius;  // a state every 10 cm
    state.time = i * kInterval;
    state.pose = {{radius * std::sin(angle), radius * (1 - std::cos(angle))}, angle};
    return state;
  };
  std::vector<PlanarPose> nodes = {state_at(0).pose};
  path.add(state_at(0));
  for (int i = 1; i <= 60; ++i) {
    if (path.add(state_at(i))) nodes.push_back(state_at(i).pose);
  }
  ASSERT_EQ(nodes.size(), path.nodes());
  for (int i = 0; i <= 60; i += 7) {
    const PathState truth = state_at(i);
    const double distance = path.distance_at(truth.time);
    for (const MapPath::Place& place : {path.place(truth.time, distance), path.place(truth.time)}) {
      const PlanarPose there = compose(nodes[place.node], place.at);
      EXPECT_LT((there.p - truth.pose.p).norm(), 1e-3) << i;
      EXPECT_NEAR(there.yaw, truth.pose.yaw, 1e-3) << i;
      // All of the way from the node was driven, on the step to it or on the step from it.
      EXPECT_EQ(place.way.p, place.at.p);
      EXPECT_EQ(place.way.to_node, truth.time < path.time_of(place.node)) << i;
    }
  }
}

// There and back: places on the way out stay right when most nodes of the way back are removed.
TEST(MapPath, PlacesNearRemovedNodesBelongToTheRemainingOnes) {
  MapPath path(0.5);
  std::vector<PlanarPose> nodes;
  for (int i = 0; i <= 80; ++i) {
    const PathState state = state_at(i * kInterval, 0.1 * (i <= 40 ? i : 80 - i), 0.0);
    const bool first = path.empty();
    if (path.add(state) || first) nodes.push_back(state.pose);
  }
  std::vector<bool> stay(nodes.size(), true);
  std::vector<PlanarPose> left;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    stay[i] = i <= 6 || i + 3 >= nodes.size();
    if (stay[i]) left.push_back(nodes[i]);
  }
  path.keep_only(stay);
  ASSERT_EQ(path.nodes(), left.size());
  EXPECT_TRUE(path.begins_piece(7));
  EXPECT_FALSE(path.is_forgotten(20 * kInterval));
  EXPECT_TRUE(path.is_forgotten(50 * kInterval));
  for (const int i : {2, 13, 29, 31, 70, 78}) {  // 31: a little beyond the last node of the way out
    const double x = 0.1 * (i <= 40 ? i : 80 - i);
    const MapPath::Place place = path.place(i * kInterval, x);
    EXPECT_NEAR(compose(left[place.node], place.at).p.x(), x, 1e-9) << i;
    EXPECT_EQ(place.direction, i <= 40 ? 1 : -1) << i;
  }
}

}  // namespace
}  // namespace gprodom
