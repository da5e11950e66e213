// What others give the estimator: a radar front end in place of gpr.front_end, displacements of
// another process, factors, positions, and messages that overtake each other.
#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "gprodom/front_end.h"
#include "gprodom/odometry.h"
#include "gprodom/user_factor.h"
#include "pipeline/test_drive.h"
#include "support/told.h"

namespace gprodom {
namespace {

constexpr TimeNs kTick = 100'000'000;

// Where the robot of there_and_back() is, at multiples of the IMU's period.
double position_at(TimeNs time) {
  static const std::vector<double> positions = [] {
    std::vector<double> found;
    for (const Input& input : there_and_back(1))
      if (const auto* wheel = std::get_if<WheelSample>(&input))
        found.push_back(wheel->distance_m / 1.01);  // the scale of its wheel
    return found;
  }();
  const auto i = static_cast<std::size_t>(std::max<TimeNs>(0, (time - kDriveStart) / kImuPeriod));
  return positions[std::min(i, positions.size() - 1)];
}

// The scale and the sign of a TrackDisplacement, and its weight: no wheel tells the way.
TEST(OwnFrontEnd, ItsDisplacementsCarryARobotWithoutAWheel) {
  const auto way = [](TimeNs tick) {
    const double moved_m = position_at(tick) - position_at(tick - kTick);
    return std::vector<gpr::Finding>{
        gpr::TrackDisplacement{tick - kTick, tick, "own", true, moved_m, 0.003}};
  };
  const Config config = default_config({"wheel.enabled=false", "graph.enabled=false"});
  Odometry with(config, Execution::kInline, saying(way));
  const Outputs out = run(with, there_and_back(1));
  double farthest = 0.0;  // along the track: nothing holds the robot from drifting aside
  for (const auto& estimate : out.odometry) farthest = std::max(farthest, estimate.p_odom_body.x());
  const double truth = position_at(kDriveStart + from_seconds(19.0));
  EXPECT_NEAR(farthest, truth, 0.02 * truth);
  ASSERT_FALSE(out.odometry.empty());
  EXPECT_NEAR(out.odometry.back().p_odom_body.x(), 0.0, 0.02 * truth) << "the way back has a sign";
  EXPECT_TRUE(
      std::all_of(out.displacements.begin(), out.displacements.end(), [](const Displacement& d) {
        return d.source == "own" && d.kind == DisplacementKind::kSequential;
      }));
}

// The drive up to its turn, and what another process says of the way at each tick, so much late.
std::vector<Input> with_answers(TimeNs late, DisplacementKind kind) {
  std::vector<Input> inputs;
  for (const Input& input : there_and_back(1)) {
    const auto* imu = std::get_if<ImuSample>(&input);
    if (imu && imu->time > kDriveStart + from_seconds(18.5)) break;
    inputs.push_back(input);
    if (!imu || (imu->time - kDriveStart) % kTick != 0) continue;
    Displacement told;
    told.to = told.time = imu->time - late;
    told.from = told.to - 5 * kTick;
    if (told.from < kDriveStart) continue;
    told.kind = kind;
    told.valid = true;
    told.source = "another process";
    told.distance_m = position_at(told.to) - position_at(told.from);
    told.sigma_m = 0.005;
    inputs.emplace_back(told);
  }
  return inputs;
}

TEST(AnotherProcess, ItsMotionReachesItsStateWithinTheReorderWindowAndIsCountedBeyond) {
  const Config config = default_config({"wheel.enabled=false", "graph.enabled=false"});
  const double truth = position_at(kDriveStart + from_seconds(18.5));
  for (const DisplacementKind kind : {DisplacementKind::kMotion, DisplacementKind::kExternal}) {
    Odometry in_time(config);
    const Outputs carried =
        run(in_time, with_answers(from_seconds(config.time.reorder_window) - kTick / 2, kind));
    ASSERT_FALSE(carried.odometry.empty());
    EXPECT_NEAR(carried.odometry.back().p_odom_body.x(), truth, 0.02 * truth);
    EXPECT_TRUE(carried.warnings.empty());
  }
  Odometry late(config);
  const Outputs alone = run(late, with_answers(from_seconds(config.time.reorder_window) + kTick / 2,
                                               DisplacementKind::kMotion));
  ASSERT_FALSE(alone.odometry.empty());
  EXPECT_GT(std::abs(alone.odometry.back().p_odom_body.x() - truth), 0.02 * truth);
  EXPECT_GE(count_with(alone.warnings, "later than time.reorder_window"), 1);
}

// A Standstill is not a displacement of 0: it stands against the wheel.
TEST(OwnFrontEnd, ItsStandstillHoldsAgainstAWheelThatSpins) {
  std::vector<Input> spinning;
  for (Input& input : standing(20.0)) {
    auto* wheel = std::get_if<WheelSample>(&input);
    const double since = std::max(0.0, to_seconds(time_of(input) - kDriveStart) - 8.0);
    if (wheel) wheel->distance_m = 0.01 * since * since;
    spinning.push_back(input);
    if (wheel) spinning.emplace_back(gpr::flat_trace(wheel->time));
  }
  const auto stands = [](TimeNs tick) {
    return std::vector<gpr::Finding>{gpr::Standstill{tick - 3 * kTick, tick, "own", 0.001}};
  };
  const Config config = default_config({"wheel.slip_threshold=0"});  // else the IMU contradicts it
  Odometry with(config, Execution::kInline, saying(stands));
  Odometry without(config, Execution::kInline,
                   saying([](TimeNs) { return std::vector<gpr::Finding>(); }));
  const Outputs held = run(with, spinning), carried = run(without, spinning);
  ASSERT_FALSE(held.odometry.empty());
  EXPECT_LT(held.odometry.back().p_odom_body.norm(), 0.02);
  EXPECT_GT(carried.odometry.back().p_odom_body.norm(), 0.1);
}

TEST(OwnFrontEnd, IsMadeAnewWhereTheEstimatorStartsAfresh) {
  int made = 0;
  const gpr::FrontEndFactory factory = [&made] {
    ++made;
    return std::make_unique<Sayer>([](TimeNs) { return std::vector<gpr::Finding>(); });
  };
  Odometry odometry(default_config(), Execution::kInline, factory);
  EXPECT_EQ(made, 1);
  odometry.reset();
  odometry.forget();
  EXPECT_EQ(made, 3);
  const Odometry without_radar(default_config({"gpr.enabled=false"}), Execution::kInline, factory);
  EXPECT_EQ(made, 3);
  EXPECT_THROW(Odometry(default_config(), Execution::kInline,
                        [] { return std::unique_ptr<gpr::FrontEnd>(); }),
               std::invalid_argument);
}

// Each of these would else be a displacement without a weight, or spoil what the estimator learns.
TEST(OwnFrontEnd, WhatCannotBeIsDroppedWithAWarning) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto said = [&](const gpr::Finding& finding) {
    Odometry odometry(default_config(), Execution::kInline,
                      saying([&](TimeNs) { return std::vector<gpr::Finding>{finding}; }));
    const Outputs out = run(odometry, standing(5.0));
    EXPECT_TRUE(out.displacements.empty());
    return count_with(out.warnings, "finding of the radar front end dropped");
  };
  const TimeNs a = kDriveStart, b = a + kTick, future = a + from_seconds(1e4);
  EXPECT_GE(said(gpr::TrackDisplacement{a, b, "own", true, nan, 0.01}), 1);
  EXPECT_GE(said(gpr::TrackDisplacement{a, b, "own", true, 0.1, 0.0}), 1);
  EXPECT_GE(said(gpr::TrackDisplacement{b, a, "own", true, 0.1, 0.01}), 1);
  EXPECT_GE(said(gpr::TrackDisplacement{a, future, "own", true, 0.1, 0.01}), 1);
  EXPECT_GE(said(gpr::PathLength{a, b, "own", true, 0.0}), 1);
  EXPECT_GE(said(gpr::Standstill{a, b, "own", -1.0}), 1);
  EXPECT_GE(said(gpr::Sight{a, b, nan}), 1);
}

// A user's factor through the whole estimator: when it is accepted, and its effect on the pose.

// Residual: the height of the robot above the origin, with a standard deviation of 1 mm.
struct Height {
  double metres;
  template <class T>
  bool operator()(const T* p, T* r) const {
    r[0] = (p[2] - T(metres)) / T(1e-3);
    return true;
  }
};

UserFactor height_at(double seconds, double metres) {
  return {"height",
          {kDriveStart + from_seconds(seconds)},
          {{0, StatePart::kPosition}},
          std::make_shared<ceres::AutoDiffCostFunction<Height, 1, 3>>(new Height{metres}),
          nullptr};
}

// Stands for three seconds, then drives straight on.
class Drive {
 public:
  void go_on_until(double end) {
    for (; robot_.seconds() < end - 1e-9; robot_.move()) {
      ImuSample imu = robot_.imu();
      imu.acceleration += noise_.vector(0.002);
      imu.angular_velocity += noise_.vector(4e-4);
      odometry.add(imu);
      odometry.add(WheelSample{imu.time, robot_.way_m});
      const Outputs out = odometry.step();
      if (!out.odometry.empty()) newest = out.odometry.back();
      if (!out.status.empty()) status = out.status.back();
    }
  }
  Odometry odometry{without_radar()};
  OdometryEstimate newest;
  Status status;

 private:
  PlanarRobot robot_{[](double t) { return std::clamp(t - 3.0, 0.0, 0.5); }};
  Noise noise_{1};
};

TEST(AddFactor, MovesThePoseAndIsCountedInTheStatus) {
  Drive drive;
  drive.go_on_until(10.0);
  EXPECT_LT(std::abs(drive.newest.p_odom_body.z()), 0.02);
  for (double t = 10.0; t < 11.95; t += 0.1) {
    EXPECT_EQ(drive.odometry.add_factor(height_at(t + 0.03, 0.1)), "");
    drive.go_on_until(t + 0.1);
  }
  drive.go_on_until(13.5);  // past the status of the second in which the last was used
  EXPECT_NEAR(drive.newest.p_odom_body.z(), 0.1, 0.02);
  EXPECT_EQ(value_of(drive.status, "factors.used"), 20);
}

TEST(AddFactor, IsRefusedOutsideTheLag) {
  Drive drive;
  EXPECT_EQ(drive.odometry.add_factor(height_at(0.0, 0.0)), "the estimator has not started");
  drive.go_on_until(10.0);
  EXPECT_EQ(drive.odometry.add_factor(height_at(3.0, 0.0)), "older than the window (smoother.lag)");
  EXPECT_EQ(drive.odometry.add_factor(height_at(6.0, 0.0)), "");
  EXPECT_EQ(drive.odometry.add_factor(height_at(20.0, 0.0)), "too far ahead of the IMU");
  UserFactor factor = height_at(9.0, 0.0);
  factor.blocks[0].part = StatePart::kAttitude;
  EXPECT_NE(drive.odometry.add_factor(factor), "");
}

// Messages of different sensors that overtake each other on their way.

// The published poses if each sample of the wheel comes so many IMU samples late.
std::vector<OdometryEstimate> poses(std::size_t late) {
  Odometry odometry(default_config({"gpr.enabled=false"}));
  std::deque<WheelSample> on_the_way;
  std::vector<OdometryEstimate> found;
  for (const Input& input : there_and_back(1)) {
    if (const auto* wheel = std::get_if<WheelSample>(&input)) {
      on_the_way.push_back(*wheel);
      if (on_the_way.size() > late) {
        odometry.add(on_the_way.front());
        on_the_way.pop_front();
      }
    }
    if (const auto* imu = std::get_if<ImuSample>(&input)) odometry.add(*imu);
    for (const OdometryEstimate& pose : odometry.step().odometry) found.push_back(pose);
  }
  return found;
}

// The pose uses wheel samples between two solutions, so an IMU message that comes before or after
// one of them could change it: then a ROS node would differ from the replay of its log.
TEST(Arrival, WheelThatComesAFewImuSamplesLateChangesNoPose) {
  const auto in_order = poses(0), late = poses(4);
  EXPECT_GT(in_order.size(), 3000U);
  EXPECT_TRUE(same_poses(in_order, late));
}

// Positions from outside: `map` becomes `site`, also without a radar, and `odom` does not know it.
struct Driven {
  Outputs out;
  std::vector<OdometryEstimate> smoothed;
};

// There and back on 9 m, in site towards (cos 1, sin 1) from (100, 50). with_fixes: each second,
// exact.
Driven driven(bool with_fixes) {
  Odometry odometry(default_config({"gpr.enabled=false"}));
  odometry.record();
  const auto inputs = there_and_back(3);
  Outputs out = run(odometry, with_fixes ? fixed(inputs) : inputs);
  return {std::move(out), odometry.smoothed()};
}

TEST(Fixes, TurnMapToSiteAndLeaveOdomAsItIs) {
  const Driven with = driven(true), without = driven(false);
  EXPECT_TRUE(same_poses(with.out.odometry, without.out.odometry));
  const Eigen::Vector3d home(100, 50, 0);
  const OdometryEstimate& in_map = with.out.odometry_in_map.back();
  EXPECT_LT((in_map.p_odom_body - home).norm(), 0.1);
  EXPECT_NEAR(std::abs(in_map.q_odom_body.z()), std::sin(0.5), 0.02);
  EXPECT_LT((with.smoothed.back().p_odom_body - home).norm(), 0.05);
  EXPECT_LT((with.smoothed.front().p_odom_body - home).norm(), 0.05);
  EXPECT_LT(without.out.odometry_in_map.back().p_odom_body.norm(), 1.0) << "map stays odom";
  EXPECT_EQ(count_with(reasons_in(with.out), "fixes"), 0);
}

}  // namespace
}  // namespace gprodom
