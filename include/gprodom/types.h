// Measurements and estimates that cross the public interface: plain values, SI units, no behaviour.
//
// Time is data time in integer nanoseconds since 1970 (messages carry microseconds).
// Frames follow REP-105: `body` x forward, y left, z up; `odom` is continuous; `map` may jump.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace gprodom {

using TimeNs = std::int64_t;

constexpr TimeNs kSecond = 1'000'000'000;

constexpr TimeNs from_seconds(double seconds) {
  return static_cast<TimeNs>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5));
}
constexpr double to_seconds(TimeNs duration) { return static_cast<double>(duration) * 1e-9; }

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Specific force (m/s^2, +g upwards at rest) and angular rate (rad/s), in the IMU's own frame.
struct ImuSample {
  TimeNs time = 0;
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
};

// Signed cumulative distance as the encoder reports it (ticks times metres per tick), metres.
struct WheelSample {
  TimeNs time = 0;
  double distance_m = 0.0;
  double resolution_m = 0.0;  // of one tick of the encoder; 0: finer than wheel.noise_floor
};

// The same of the left and the right side. Of several wheels of one side, their mean.
struct WheelsSample {
  TimeNs time = 0;
  double left_m = 0.0;
  double right_m = 0.0;
  double resolution_m = 0.0;  // as of WheelSample
};

// One radar trace, in counts. Sample i was taken at i * sample_interval_s - time_zero_s after the
// pulse left the antenna.
struct GprTrace {
  TimeNs time = 0;
  std::int64_t seq = 0;
  std::int32_t antenna_id = 0;
  double sample_interval_s = 0.0;
  double time_zero_s = 0.0;
  double volts_per_count = 0.0;  // 0: unknown
  std::vector<float> samples;
};

// The kind of a displacement along the track, from a radar front end or another process. The values
// of the enums here are those of lcmtypes/, which src/io/lcm_constants.cpp checks.
enum class DisplacementKind : std::int8_t {
  kSequential = 0,
  kMotion = 1,
  kRevisit = 2,
  kExternal = 3
};

// A displacement along the track (m) between two times, with its standard deviation (m).
// kMotion is unsigned; a valid distance of 0 means that the robot stood from `from` to `to`.
struct Displacement {
  TimeNs time = 0;  // when it takes effect
  TimeNs from = 0;
  TimeNs to = 0;
  std::string source;
  DisplacementKind kind = DisplacementKind::kMotion;
  bool valid = false;
  double distance_m = 0.0;
  double sigma_m = 0.0;
  double lateral_m = 0.0;
  double lateral_sigma_m = 0.0;
  bool mirrored = false;
  double scale = 1.0;
  double score = 0.0;
};

// Bits of odometry_t.flags.
enum OdometryFlags : std::int32_t {
  kStanding = 1,       // the robot does not move
  kSlipping = 2,       // wheel slip; comes with kWheelFast or kWheelSlow
  kNoWheel = 4,        // no wheel data in use
  kNoRadar = 8,        // no radar data in use
  kImuGap = 16,        // IMU data were missing since the last state
  kSolverFailed = 32,  // the last solve failed; the state is the last good one, propagated
  kWheelFast = 64,     // slip: the wheel is faster than the ground (it spins)
  kWheelSlow = 128,    // slip: the wheel is slower than the ground (it skids)
  kLeftSlips = 256,    // the left wheels slip; only the right ones are used
  kRightSlips = 512,   // the right wheels slip; only the left ones are used
  kImmobilised = 1024  // the wheels turn, and the ground under the antenna stands
};

// Covariances: pose as [position (m), rotation vector (rad)], both in `odom` axes, of the error
// p_estimate - p and R_estimate R^T; velocity in body axes.
struct OdometryEstimate {
  TimeNs time = 0;
  Eigen::Vector3d p_odom_body = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_odom_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_body = Eigen::Vector3d::Zero();
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();
  Matrix6d pose_covariance = Matrix6d::Zero();
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  double wheel_scale = 1.0;
  double wheel_scale_sigma = 0.0;
  double distance_m = 0.0;  // travelled, unsigned, since the start
  std::int32_t flags = 0;
};

// map -> odom: p_map = R(q) p_odom + p. The covariance is that of the robot's pose in map at `time`
// (as in OdometryEstimate, in map axes). A covariance of the correction itself could not be added
// to that of the odometry, since the correction removes the errors of the odometry.
struct Correction {
  TimeNs time = 0;
  Eigen::Vector3d p_map_odom = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_map_odom = Eigen::Quaterniond::Identity();
  std::int32_t revisits = 0;
  Matrix6d covariance = Matrix6d::Zero();
};

constexpr int kMaxFeatureLevel = 10;

// A subsurface feature matrix: rows of depth, columns along the track, levels from 0 (no feature)
// to kMaxFeatureLevel.
struct SubsurfaceFeatureMatrix {
  TimeNs time = 0;
  Eigen::Matrix<std::int8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> level;
  double column_spacing_s = 0.0;  // in seconds where columns follow time, as in the paper
};

// About where the robot is, in a map of earlier ground.
struct RoughPlace {
  double x = 0.0, y = 0.0;  // m
  double yaw = 0.0;         // rad
  double sigma_m = 0.5;     // standard deviation of the position
  int map = -1;             // number of the map; -1: the one with the most ground
};

enum class HealthLevel : std::int8_t { kOk = 0, kDegraded = 1, kFailed = 2 };

// A value of a live Status: a number of the process that sends it, by which a second process on the
// same channels is noticed. It is not in the Status of a replay.
constexpr char kInstance[] = "instance";

struct Status {
  TimeNs time = 0;
  HealthLevel health = HealthLevel::kOk;
  std::vector<std::string> reasons;
  std::vector<std::string> names;  // names[i] of values[i]
  std::vector<double> values;
};

}  // namespace gprodom
