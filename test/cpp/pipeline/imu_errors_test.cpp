// An IMU that is mounted at any rotation, or whose accelerometer has a wrong scale or a large bias,
// through the whole estimator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimation/nav_state.h"
#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "pipeline/pipeline.h"
#include "pipeline/test_drive.h"
#include "support/noise.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;
using Mounting = std::function<Vector3d(const Vector3d&)>;  // body axes -> the IMU's own

constexpr double kSpeed = 0.5;    // m/s
constexpr double kYawRate = 0.2;  // rad/s, to the left
constexpr double kTurn = 6.0;     // s
constexpr double kTurnsIn = 0.5;  // s

struct Driven {
  std::vector<OdometryEstimate> odometry;
  PlanarRobot robot;
  std::vector<std::string> warnings;  // and reasons of STATUS

  bool told(const std::string& part) const { return count_with(warnings, part) > 0; }
  double error_m() const { return (odometry.back().p_odom_body - robot.position).norm(); }
};

// Four seconds of standstill, then ahead, round a bend to the left, and ahead.
Driven drive(const Config& config, const Mounting& mounted, const Vector3d& arm = Vector3d::Zero(),
             Execution execution = Execution::kInline) {
  const auto bend = [](double t) {  // from 0 to 1, and back
    return std::clamp(std::min(t - 8.0, 8.0 + kTurn + kTurnsIn - t) / kTurnsIn, 0.0, 1.0);
  };
  Driven run{{},
             PlanarRobot([](double t) { return kSpeed * std::clamp(t - 4.0, 0.0, 1.0); },
                         [bend](double t) { return kYawRate * bend(t); }),
             {}};
  Odometry odometry(config, execution);
  Outputs all;
  for (int i = 0; i < 2000; ++i, run.robot.move()) {
    const double t = run.robot.seconds();
    const ImuSample noise = resting_imu(0, i);
    ImuSample imu = run.robot.imu();
    const Vector3d angular(0, 0, kYawRate * (bend(t + 0.005) - bend(t - 0.005)) / 0.01);
    const Vector3d by_arm =
        angular.cross(arm) + imu.angular_velocity.cross(imu.angular_velocity.cross(arm));
    const Vector3d gravity(0, 0, kStandardGravity);
    imu.acceleration = mounted(imu.acceleration + noise.acceleration - gravity + by_arm);
    imu.angular_velocity = mounted(imu.angular_velocity + noise.angular_velocity);
    odometry.add(imu);
    odometry.add(WheelSample{imu.time, run.robot.way_m});
    append(all, odometry.step());
    odometry.start_jobs();
  }
  odometry.finish();
  run.odometry = all.odometry;
  run.warnings = reasons_in(all);
  run.warnings.insert(run.warnings.end(), all.warnings.begin(), all.warnings.end());
  return run;
}

double yaw_of(const OdometryEstimate& estimate) {
  const Vector3d ahead = estimate.q_odom_body * Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

Vector3d along_body(const Vector3d& v) { return v; }

// The mounting written out axis by axis, and what the configuration calls it.
struct Case {
  const char* name;
  Vector3d rpy_body_imu;
  Mounting mounted;
};

const Case kCases[] = {
    {"upside down",
     {M_PI, 0, 0},
     [](const Vector3d& v) { return Vector3d(v.x(), -v.y(), -v.z()); }},
    {"x to the left",
     {0, 0, M_PI / 2},
     [](const Vector3d& v) { return Vector3d(v.y(), -v.x(), v.z()); }},
    {"x down", {0, M_PI / 2, 0}, [](const Vector3d& v) { return Vector3d(-v.z(), v.y(), v.x()); }},
    {"y up, z back",
     {M_PI / 2, 0, -M_PI / 2},
     [](const Vector3d& v) { return Vector3d(-v.y(), v.z(), -v.x()); }},
    // Roll about x first, then pitch about y, then yaw about z of the body.
    {"askew", {0.3, -0.5, 2.0}, [](const Vector3d& v) {
       const double r = 0.3, p = -0.5, y = 2.0;
       const Vector3d a(std::cos(y) * v.x() + std::sin(y) * v.y(),
                        -std::sin(y) * v.x() + std::cos(y) * v.y(), v.z());
       const Vector3d b(std::cos(p) * a.x() - std::sin(p) * a.z(), a.y(),
                        std::sin(p) * a.x() + std::cos(p) * a.z());
       return Vector3d(b.x(), std::cos(r) * b.y() + std::sin(r) * b.z(),
                       -std::sin(r) * b.y() + std::cos(r) * b.z());
     }}};

TEST(Mounting, AnyConfiguredRotationGivesTheSameTrueEstimate) {
  const Driven straight = drive(without_radar(), along_body);
  ASSERT_GT(straight.odometry.size(), 1000u);
  EXPECT_LT(straight.error_m(), 0.05);
  EXPECT_NEAR(yaw_of(straight.odometry.back()), kYawRate * kTurn, 0.02);
  for (const Case& c : kCases) {
    Config config = without_radar();
    config.imu.rpy_body_imu = c.rpy_body_imu;
    const Driven turned = drive(config, c.mounted);
    ASSERT_EQ(turned.odometry.size(), straight.odometry.size()) << c.name;
    const OdometryEstimate &a = straight.odometry.back(), &b = turned.odometry.back();
    EXPECT_LT((a.p_odom_body - b.p_odom_body).norm(), 1e-6) << c.name;
    EXPECT_LT(a.q_odom_body.angularDistance(b.q_odom_body), 1e-6) << c.name;
    EXPECT_LT((a.v_body - b.v_body).norm(), 1e-6) << c.name;
    EXPECT_LT((a.omega_body - b.omega_body).norm(), 1e-9) << c.name;
    EXPECT_LT((a.pose_covariance - b.pose_covariance).norm(), 1e-6 * a.pose_covariance.norm());
    EXPECT_EQ(a.flags, b.flags) << c.name;
  }
}

// With imu.rpy_body_imu auto, starts and bends show it, and the data that have shown it are
// estimated again: all states of the recording are as if it had been configured.
TEST(Mounting, AMountingThatIsNotConfiguredIsFound) {
  for (const Case& c : kCases) {
    Config config = without_radar();
    config.imu.rpy_body_imu.rpy.reset();
    const Driven found = drive(config, c.mounted);
    ASSERT_GT(found.odometry.size(), 1000u) << c.name;
    const OdometryEstimate& end = found.odometry.back();
    EXPECT_LT(found.error_m(), 0.06) << c.name;
    EXPECT_NEAR(yaw_of(end), kYawRate * kTurn, 0.02) << c.name;
    EXPECT_TRUE(std::is_sorted(found.odometry.begin(), found.odometry.end(),
                               [](const auto& a, const auto& b) { return a.time < b.time; }));
  }
}

// A yaw that is configured wrongly is contradicted by the first starts and bends.
TEST(Mounting, AWrongYawIsCorrected) {
  Config config = without_radar();
  config.imu.rpy_body_imu = Vector3d(0, 0, -M_PI / 2);
  const Driven wrong = drive(config, along_body);
  EXPECT_TRUE(wrong.told("contradict"));
  EXPECT_LT(wrong.error_m(), 0.06);
}

// On the move, with a wheel that jumps and a mean force that is off gravity: a first estimate would
// wait. One of data that have been estimated before begins where that one did, or odom would turn.
TEST(Mounting, DataAreEstimatedAgainFromWhereTheFirstEstimateBegan) {
  StartingPoint again;
  again.begins_at = kDriveStart + 523 * kImuPeriod;
  Pipeline pipeline(without_radar(), Execution::kInline, {}, std::move(again));
  Outputs all;
  for (int i = 0; i < 600; ++i) {
    ImuSample imu = resting_imu(kDriveStart + i * kImuPeriod, i);
    imu.acceleration.x() += 5.0;
    pipeline.add(imu);
    pipeline.add(WheelSample{imu.time, 0.01 * i + (i > 400 ? 0.3 : 0.0)});
    append(all, pipeline.step());
  }
  ASSERT_FALSE(all.odometry.empty());
  EXPECT_NEAR(to_seconds(all.odometry.front().time - kDriveStart), 5.23, 0.02);
}

// Solutions of threads may come late here, so only the course of events is as above.
TEST(Mounting, AMountingIsFoundWithThreads) {
  Config config = without_radar();
  config.imu.rpy_body_imu.rpy.reset();
  const Driven found = drive(config, kCases[4].mounted, Vector3d::Zero(), Execution::kThreaded);
  EXPECT_TRUE(found.told("IMU mounting found"));
  EXPECT_TRUE(std::is_sorted(found.odometry.begin(), found.odometry.end(),
                             [](const auto& a, const auto& b) { return a.time < b.time; }));
  for (const OdometryEstimate& estimate : found.odometry)
    EXPECT_TRUE(estimate.p_odom_body.allFinite());
}

// What one run has found is known to the next from its first pose on.
TEST(Mounting, TheNextRunKnowsWhatWasFound) {
  const TemporaryFolder folder;
  Config config = without_radar();
  config.imu.rpy_body_imu.rpy.reset();
  config.state.directory = folder.path();
  config.state.resume_within = 0;
  const Mounting askew = kCases[4].mounted;
  EXPECT_TRUE(drive(config, askew).told("IMU mounting: being found"));
  const Driven next = drive(config, askew);
  EXPECT_FALSE(next.told("IMU mounting: being found"));
  EXPECT_LT(next.error_m(), 0.06);
  // It was mounted otherwise in between.
  EXPECT_TRUE(drive(config, along_body).told("its mounting is found anew"));
}

// An IMU beside the origin measures what turning adds; imu.lever_arm takes it out.
TEST(Mounting, ALeverArmIsTakenOut) {
  const Vector3d arm(0.5, -0.2, 0.3);
  Config config = without_radar();
  const double ignored_m = drive(config, along_body, arm).error_m();
  config.imu.lever_arm = arm;
  const double error_m = drive(config, along_body, arm).error_m();
  EXPECT_LT(error_m, 0.05);
  EXPECT_GT(ignored_m, 2 * error_m);
}

using Sensor = std::function<Vector3d(const Vector3d&)>;  // what it makes of a specific force

constexpr double kRound_s = 6.0;

struct Course {
  std::optional<double> start_s;
  double worst_m = 0.0;  // error of the position
  std::vector<std::string> reasons;
  bool told(const std::string& text) const { return count_with(reasons, text) > 0; }
};

// A robot that stands for `stands` seconds, and then turns on the spot by 0.7 rad and goes ahead by
// 0.75 m, for 3 s each.
Course course_by(const Sensor& sensor, double stands_s = 3.0, unsigned seed = 1) {
  Course run;
  Odometry odometry(without_radar());
  Noise noise(seed);
  const auto bump = [](double t) { return 0.5 - 0.5 * std::cos(2 * M_PI * t / (0.5 * kRound_s)); };
  const auto speed_at = [&](double t) {
    const double in_round = t < stands_s ? 0.0 : std::fmod(t - stands_s, kRound_s);
    return in_round > 0.5 * kRound_s ? 0.5 * bump(in_round) : 0.0;
  };
  const auto rate_at = [&](double t) {
    const double in_round = t < stands_s ? kRound_s : std::fmod(t - stands_s, kRound_s);
    return in_round < 0.5 * kRound_s ? 0.47 * bump(in_round) : 0.0;
  };
  PlanarRobot robot(speed_at, rate_at);
  PlanarRobot first = robot;
  for (; robot.seconds() < 60.0; robot.move()) {
    ImuSample imu = robot.imu();
    imu.acceleration = sensor(imu.acceleration + noise.vector(0.02));
    imu.angular_velocity += noise.vector(0.001);
    odometry.add(imu);
    odometry.add(WheelSample{imu.time, robot.way_m});
    const Outputs out = odometry.step();
    for (const OdometryEstimate& estimate : out.odometry) {
      if (!run.start_s) {
        run.start_s = robot.seconds();
        first = robot;
      }
      const Vector3d moved =
          Eigen::AngleAxisd(-first.yaw, Vector3d::UnitZ()) * (robot.position - first.position);
      run.worst_m = std::max(run.worst_m, (estimate.p_odom_body - moved).head<2>().norm());
    }
    for (const std::string& reason : reasons_in(out)) run.reasons.push_back(reason);
  }
  return run;
}

Sensor scaled(double scale) {
  return [scale](const Vector3d& force) { return Vector3d(scale * force); };
}

const char* const kTold = "accelerometer: its specific force is ";

TEST(Accelerometer, AWrongScaleIsTakenOutAndTold) {
  const Course right = course_by(scaled(1.0));
  ASSERT_TRUE(right.start_s);
  EXPECT_LT(right.worst_m, 0.03);
  EXPECT_FALSE(right.told("accelerometer"));
  for (const double scale : {0.55, 0.8, 1.2, 1.45}) {
    const Course run = course_by(scaled(scale));
    ASSERT_TRUE(run.start_s) << scale;
    EXPECT_EQ(*run.start_s, *right.start_s);
    EXPECT_NEAR(run.worst_m, right.worst_m, 2e-3) << scale;
    const std::string percent = std::to_string(std::lround(100 * scale));
    EXPECT_TRUE(run.told(kTold + percent + " % of gravity")) << scale;
  }
}

// Another unit, or no accelerometer.
TEST(Accelerometer, WhatIsFarFromGravityIsNoScale) {
  for (const double scale : {1 / kStandardGravity, 0.0, 0.4, 1.6}) {
    const Course run = course_by(scaled(scale), 60.0);
    EXPECT_FALSE(run.start_s) << scale;
    EXPECT_TRUE(run.told("is not gravity")) << scale;
    EXPECT_FALSE(run.told(kTold)) << scale;
  }
}

// Accelerations of a drive are not known so well: it waits for as long as for other signs.
TEST(Accelerometer, AWrongScaleIsTakenOutOnTheMove) {
  for (const double scale : {0.8, 1.2}) {
    const Course run = course_by(scaled(scale), -2.9);
    ASSERT_TRUE(run.start_s) << scale;
    EXPECT_LT(*run.start_s, 15.0);
    EXPECT_LT(run.worst_m, 0.1) << scale;
    EXPECT_TRUE(run.told(kTold)) << scale;
  }
}

// Across gravity no standstill tells a bias from a tilt; along it, that the sensor has some.
TEST(Accelerometer, ABiasIsLearntFromTurnsIfGravityShowsThatThereIsSome) {
  const Vector3d bias(0.3, -0.2, 0.2);
  const Sensor biased = [&](const Vector3d& force) { return Vector3d(force + bias); };
  double mean_m = 0.0, right_m = 0.0;
  constexpr unsigned kDrives = 12;
  for (unsigned seed = 1; seed <= kDrives; ++seed) {
    mean_m += course_by(biased, 3.0, seed).worst_m / kDrives;
    right_m += course_by(scaled(1.0), 3.0, seed).worst_m / kDrives;
  }
  EXPECT_LT(mean_m, right_m + 0.01);
}

// An encoder of some centimetres a tick, as a few magnets on a wheel give it.
// Goes 1.4 m in 4 s and stands for 2 s, again and again. The greatest error of the position, m.
double worst_error(unsigned seed, double tick_m, double resolution_m) {
  constexpr double kStands = 3.0, kGoes = 4.0, kRound = 6.0, kSpeed = 0.7;  // s, m/s
  Odometry odometry(default_config({"gpr.enabled=false"}));
  Noise noise(seed);
  const auto speed_at = [&](double t) {
    const double in_round = t < kStands ? kRound : std::fmod(t - kStands, kRound);
    const double middle = 0.5 * kGoes;
    return kSpeed * std::max(0.0, 1.0 - std::abs(in_round - middle) / middle);
  };
  PlanarRobot robot(speed_at);
  double worst = 0.0;
  for (int i = 0; i < 6000; ++i, robot.move()) {
    ImuSample imu = robot.imu();
    imu.acceleration += noise.vector(0.05);
    imu.angular_velocity = noise.vector(0.002);
    odometry.add(imu);
    const double ticks = std::floor(robot.way_m / tick_m);
    if (i % 5 == 0) odometry.add(WheelSample{imu.time, tick_m * ticks, resolution_m});
    for (const OdometryEstimate& estimate : odometry.step().odometry)
      if (estimate.time == imu.time)
        worst = std::max(worst, std::abs(estimate.p_odom_body.x() - robot.way_m));
  }
  return worst;
}

TEST(CoarseEncoder, ItsTicksAreNeitherSlipNorStandstill) {
  for (const double tick_m : {0.02, 0.05}) {
    double with = 0.0, without = 0.0;
    for (const unsigned seed : {1, 2}) {
      with = std::max(with, worst_error(seed, tick_m, tick_m));
      without = std::max(without, worst_error(seed, tick_m, 0.0));
    }
    EXPECT_LT(with, 0.05 + 4 * tick_m);
    EXPECT_GT(without, 4 * with) << "the resolution need not be known";
  }
}

}  // namespace
}  // namespace gprodom
