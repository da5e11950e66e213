// Every setting of the estimator, with its default in place. config/gprodom.yaml states the same
// keys, units and defaults for operators; a test holds the two together.
//
// There is a setting where a user of another robot, radar or ground would set it and can know the
// value. What is the same for every robot is a constant beside the code that uses it;
// src/config/former_keys.cpp says what became of the settings of earlier versions. The keys of the
// paper's method stand in a section of their own, `paper`.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gprodom/choices.h"
#include "gprodom/export.h"

namespace gprodom {

// The names as they stand: load_config() has put the prefix before each that was left at its
// default.
struct ChannelConfig {
  std::string prefix;
  std::string gpr_trace = "GPR_TRACE";
  std::string imu = "IMU";
  std::string wheel = "WHEEL";
  std::string wheels = "WHEELS";
  std::string displacement_in = "GPR_DISPLACEMENT_IN";
  std::string position_fix = "POSITION_FIX";
  std::string command = "COMMAND";
  std::string displacement = "GPR_DISPLACEMENT";
  std::string odometry = "ODOMETRY";
  std::string odometry_map = "ODOMETRY_MAP";
  std::string pose = "POSE";
  std::string correction = "CORRECTION";
  std::string status = "STATUS";
  std::string sfm = "SFM";
};

struct TimeConfig {
  double reorder_window = 0.35;  // s; data later than this behind the newest are dropped
};

// rad; roll, pitch, yaw of a rotation; nothing (`auto` in YAML): the drive shows it.
struct MountingAngles {
  std::optional<Eigen::Vector3d> rpy = Eigen::Vector3d::Zero();
  MountingAngles& operator=(const Eigen::Vector3d& angles) {
    rpy = angles;
    return *this;
  }
};

struct ImuConfig {
  MountingAngles rpy_body_imu;                          // of R_body_imu
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  // m; the accelerometer's place in body
  double gyro_noise_density = 2.3e-4;   // rad/s/sqrt(Hz); floor, raised by what a standstill shows
  double accel_noise_density = 8.3e-4;  // m/s^2/sqrt(Hz); floor, likewise
  double gyro_bias_walk = 1.0e-5;       // rad/s^2/sqrt(Hz)
  double accel_bias_walk = 1.0e-4;      // m/s^3/sqrt(Hz)
  double max_acceleration = 160.0;      // m/s^2; beyond: dropped
  double max_angular_velocity = 35.0;   // rad/s; beyond: dropped
  double time_offset = 0.0;             // s; added to every stamp
};

struct WheelConfig {
  bool enabled = true;
  WheelDrive drive = WheelDrive::kSingle;  // what turns the robot
  double track = 0.5;  // m; between left and right wheels, by tape; single has no use for it
  WheelForm form = WheelForm::kIncrement;  // signed, with the gyro; or the paper's norm
  double scale = 1.0;                      // reported over true distance
  double scale_sigma = 0.02;               // prior of the scale; 0 holds it fixed
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  // m; wheel contact point in body
  double noise = 0.005;           // m/sqrt(m); random error that grows with distance
  double noise_floor = 0.0005;    // m; of an increment, from the encoder's resolution
  double lateral_noise = 0.003;   // m/sqrt(m); side slip
  double vertical_noise = 0.003;  // m/sqrt(m)
  double robust_threshold = 5.0;  // standard deviations at which an increment loses weight; 0: none
  double slip_threshold = 5.0;    // standard deviations between wheel and IMU that are slip; 0: off
  double slip_share = 0.3;        // of the way on which the wheel slips gradually; 0: it never does
  double max_speed = 0.0;         // m/s; faster increments are dropped at first; 0: learnt
  double time_offset = 0.0;       // s; added to every stamp
};

struct StandstillConfig {
  bool enabled = true;
};

struct InitializerConfig {
  double duration = 2.0;             // s of standstill needed to start
  bool wait_for_standstill = false;  // never start on the move
};

struct SmootherConfig {
  double state_rate = 5.0;  // states per second
  double lag = 5.0;         // s
  SolverKind solver = SolverKind::kChain;
  double latency = 0.05;  // s of data time from submission to effect
};

// Antenna centres in body (m), by the antenna_id of their traces.
using Antennas = std::map<int, Eigen::Vector3d>;
// s, by antenna_id; added to every stamp of its traces.
using AntennaOffsets = std::map<int, double>;

// Of what is done to each trace: the antenna's band, and the gain.
struct GprFilterConfig {
  double band_low = 1.5e8;   // Hz
  double band_high = 9.0e8;  // Hz
  double gain_rate = 0.0;    // 1/sample
  double gain_power = 0.0;   // of the sample number
  int gain_flat_after = 80;  // samples
};

// Reflections in a filtered trace, which the subsurface feature matrix is made of.
struct PeaksConfig {
  bool fit = true;  // damped sinusoid per pulse; false: envelope maxima, much cheaper
};

// Displacement between B-scan windows (front ends sfm, bscan, dec, salient and trace_count).
struct SequentialConfig {
  int window_traces = 100;  // L, traces in a window
  int rows = 50;            // D_S, of the feature matrix
  int columns = 50;         // L_S, of the feature matrix; shifts are in these columns
  double step = 0.5;        // s, Delta t between windows compared; whole ticks
  double k = 0.04;          // m per column: u = K |l*|
  double sigma = 0.05;      // m, error of K times the shift over one step
  DistanceForm distance = DistanceForm::kCosine;
  bool publish_sfm = false;  // each window's feature matrix beside the displacement
};

// Distance from the decay of trace similarity (front end motion).
struct CoherenceConfig {
  CoherenceUse use = CoherenceUse::kContradicted;  // when it enters the estimate
};

struct GprConfig {
  bool enabled = true;
  FrontEndKind front_end = FrontEndKind::kMotion;
  Trigger trigger = Trigger::kTime;  // by distance: from a wheel, none while the robot stands
  double tick = 0.1;                 // s of data time between answers
  double latency_budget = 0.05;      // s of data time from tick to effect
  double wave_speed = 1.0e8;         // m/s in the ground
  double time_offset = 0.0;          // s; added to every stamp
  AntennaOffsets time_offsets;       // in place of it, for an antenna that is named here
  Fusion fusion = Fusion::kSigned;   // how a displacement enters; the norm is the paper's
  // m; antenna centre in body. With `antennas`, load_config() sets it to that of the first of them.
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  Antennas antennas;  // empty: the antenna whose trace comes first, at lever_arm
  GprFilterConfig filter;
  PeaksConfig peaks;
  SequentialConfig sequential;
  CoherenceConfig coherence;
};

// Ground seen before, and the track in `map` that it ties together.
struct GraphConfig {
  bool enabled = true;
  double latency = 0.5;         // s of data time from a query to its effect on `map`
  double patch_length = 1.84;   // m of ground compared
  double lateral_sigma = 0.15;  // m; the antenna's footprint
};

// Positions from outside, which tie `map` to `site`.
struct AnchorConfig {
  bool enabled = true;
  Antennas antennas;  // m; in body, by the antenna_id of a fix; an id that is not here: at body
  std::optional<Eigen::Vector3d> datum;  // deg, deg, m; origin of site; empty: the first fix used
};

// What one run leaves to the next.
struct StateConfig {
  std::string directory;         // where it is kept; empty: nothing is
  MapUse map = MapUse::kExtend;  // whether new ground is written
  double save_period = 1.0;     // s of data time, of pose and wheel scale; of ground 300 times that
  double resume_within = 10.0;  // s; a saved pose not older than that is gone on from
  // Name of the robot, for the maps that it makes. Not a key: where it is empty, a live estimator
  // takes the name of its host.
  std::string robot;
};

struct LoggingConfig {
  LogLevel level = LogLevel::kInfo;
  double warning_period = 10.0;  // s between repeated warnings of one kind
};

struct Config {
  ChannelConfig channels;
  TimeConfig time;
  ImuConfig imu;
  WheelConfig wheel;
  StandstillConfig standstill;
  InitializerConfig initializer;
  SmootherConfig smoother;
  GprConfig gpr;
  GraphConfig graph;
  AnchorConfig anchor;
  StateConfig state;
  LoggingConfig logging;
};

// Reads YAML files over the defaults, a later one over those before it, then applies overrides
// "key.subkey=value" in order. Throws ConfigError ("file:line: key: what was expected") on unknown
// keys, wrong types and values out of range. A key of an earlier version that is fixed now is an
// error where it is given another value, which would have no effect; at the fixed value, and where
// a key has another name now, a line is added to `notices`.
GPRODOM_EXPORT Config load_config(const std::vector<std::string>& paths,
                                  const std::vector<std::string>& overrides = {},
                                  std::vector<std::string>* notices = nullptr);

// The same without files.
GPRODOM_EXPORT Config default_config(const std::vector<std::string>& overrides = {});

struct ConfigChange {
  std::string key, before, after;
};
GPRODOM_EXPORT std::vector<ConfigChange> differences(const Config& before, const Config& after);

// All keys with units, defaults and comments: what config/gprodom.yaml holds.
GPRODOM_EXPORT std::string describe_config(const Config& config);

}  // namespace gprodom
