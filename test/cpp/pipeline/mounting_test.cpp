// An IMU mounted at any rotation, through the whole estimator: imu.rpy_body_imu takes it out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "gprodom/config.h"
#include "gprodom/odometry.h"
#include "pipeline/pipeline.h"
#include "pipeline/test_drive.h"
#include "support/temporary_folder.h"
#include "support/told.h"

namespace gprodom {
namespace {

using Eigen::Vector3d;
using Mounting = std::function<Vector3d(const Vector3d&)>;  // body axes -> the IMU's own

constexpr double kRate = 100.0;   // Hz
constexpr double kSpeed = 0.5;    // m/s
constexpr double kYawRate = 0.2;  // rad/s, to the left
constexpr double kTurn = 6.0;     // s
constexpr double kTurnsIn = 0.5;  // s

struct Driven {
  std::vector<OdometryEstimate> odometry;
  Vector3d true_position = Vector3d::Zero();
  double true_yaw = 0.0;
  std::vector<std::string> warnings;  // and reasons of STATUS

  bool told(const std::string& part) const { return count_with(warnings, part) > 0; }
  double error_m() const { return (odometry.back().p_odom_body - true_position).norm(); }
};

// Four seconds of standstill, then ahead, round a bend to the left, and ahead.
Driven drive(const Config& config, const Mounting& mounted, const Vector3d& arm = Vector3d::Zero(),
             Execution execution = Execution::kInline) {
  Driven run;
  Odometry odometry(config, execution);
  Outputs all;
  double wheel_m = 0.0;
  for (int i = 0; i < 20 * kRate; ++i) {
    const double t = i / kRate, dt = 1 / kRate;
    const double speed = kSpeed * std::clamp(t - 4.0, 0.0, 1.0);
    const double into = (t - 8.0) / kTurnsIn, out_of = (8.0 + kTurn + kTurnsIn - t) / kTurnsIn;
    const double yaw_rate = kYawRate * std::clamp(std::min(into, out_of), 0.0, 1.0);
    const bool begins = into > 0 && into<1, ends = out_of> 0 && out_of < 1;
    const Vector3d rate(0, 0, yaw_rate), angular(0, 0, kYawRate / kTurnsIn * (begins - ends));
    const Vector3d by_arm = angular.cross(arm) + rate.cross(rate.cross(arm));
    const double ahead = t > 4.0 && t <= 5.0 ? kSpeed : 0.0;
    ImuSample imu = resting_imu(from_seconds(1000.0 + t), i);
    imu.acceleration = mounted(imu.acceleration + Vector3d(ahead, speed * yaw_rate, 0) + by_arm);
    imu.angular_velocity = mounted(imu.angular_velocity + rate);
    odometry.add(imu);
    odometry.add(WheelSample{imu.time, wheel_m});
    wheel_m += speed * dt;
    run.true_position += speed * dt * Vector3d(std::cos(run.true_yaw), std::sin(run.true_yaw), 0);
    run.true_yaw += yaw_rate * dt;
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

// Shows that the test above detects a rotation that is not compensated: the wheel then seems to
// drive along an axis that points up. (An upside-down IMU alone is levelled by gravity.)
TEST(Mounting, WrongConfiguredRotationGivesAWrongEstimate) {
  const Driven wrong = drive(without_radar(), kCases[2].mounted);
  ASSERT_FALSE(wrong.odometry.empty());
  EXPECT_GT(wrong.error_m(), 1.0);
}

}  // namespace
}  // namespace gprodom
