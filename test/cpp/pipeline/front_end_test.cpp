// A radar front end of one's own in place of gpr.front_end.
#include "gprodom/front_end.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "gprodom/odometry.h"
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

Outputs drive(Odometry& odometry, const std::vector<Input>& inputs) {
  Outputs all;
  for (const Input& input : inputs) {
    give(odometry, input);
    append(all, odometry.step());
  }
  return all;
}

// The scale and the sign of a TrackDisplacement, and its weight: no wheel tells the way.
TEST(OwnFrontEnd, ItsDisplacementsCarryARobotWithoutAWheel) {
  const auto way = [](TimeNs tick) {
    gpr::TrackDisplacement moved;
    moved.from = tick - kTick;
    moved.to = tick;
    moved.source = "own";
    moved.valid = true;
    moved.distance_m = position_at(tick) - position_at(tick - kTick);
    moved.sigma_m = 0.003;
    return std::vector<gpr::Finding>{moved};
  };
  const Config config = default_config({"wheel.enabled=false", "graph.enabled=false"});
  Odometry with(config, Execution::kInline, saying(way));
  const Outputs out = drive(with, there_and_back(1));
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
        drive(in_time, with_answers(from_seconds(config.time.reorder_window) - kTick / 2, kind));
    ASSERT_FALSE(carried.odometry.empty());
    EXPECT_NEAR(carried.odometry.back().p_odom_body.x(), truth, 0.02 * truth);
    EXPECT_TRUE(carried.warnings.empty());
  }
  Odometry late(config);
  const Outputs alone =
      drive(late, with_answers(from_seconds(config.time.reorder_window) + kTick / 2,
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
    gpr::Standstill standstill;
    standstill.from = tick - 3 * kTick;
    standstill.to = tick;
    standstill.source = "own";
    standstill.sigma_m = 0.001;
    return std::vector<gpr::Finding>{standstill};
  };
  const Config config = default_config({"wheel.slip_threshold=0"});  // else the IMU contradicts it
  Odometry with(config, Execution::kInline, saying(stands));
  Odometry without(config, Execution::kInline,
                   saying([](TimeNs) { return std::vector<gpr::Finding>(); }));
  const Outputs held = drive(with, spinning), carried = drive(without, spinning);
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
}

TEST(OwnFrontEnd, NoneIsRefused) {
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
    const Outputs out = drive(odometry, standing(5.0));
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

}  // namespace
}  // namespace gprodom
