// Every setting of the estimator, with its default in place. config/gprodom.yaml states the same
// keys, units and defaults for operators; a test holds the two together.
//
// A field has a key where a user of another robot, radar or ground would set it and can know the
// value. The others are the same for every robot: they are fixed at the defaults here, and are
// fields so that tests can vary them (src/config/former_keys.cpp says why each is fixed). The keys
// of the paper's method stand in a section of their own, `paper`.
#pragma once

#include <Eigen/Core>
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
  double max_jump = 5.0;         // s; a stamp further ahead of the others than this is a jump
  double imu_gap = 0.1;          // s; IMU data further apart than this are a gap
};

struct ImuConfig {
  Eigen::Vector3d rpy_body_imu = Eigen::Vector3d::Zero();  // rad; roll, pitch, yaw of R_body_imu
  double gyro_noise_density = 2.3e-4;   // rad/s/sqrt(Hz); floor, raised by what a standstill shows
  double accel_noise_density = 8.3e-4;  // m/s^2/sqrt(Hz); floor, likewise
  double gyro_bias_walk = 1.0e-5;       // rad/s^2/sqrt(Hz)
  double accel_bias_walk = 1.0e-4;      // m/s^3/sqrt(Hz)
  double accel_bias_sigma = 0.03;       // m/s^2; prior of the accelerometer bias
  bool adaptive_noise = true;           // raise the noise of an interval to what its samples show
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
  double scale_walk = 1.0e-6;              // 1/sqrt(s); random walk of the scale
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  // m; wheel contact point in body
  double noise = 0.005;           // m/sqrt(m); random error that grows with distance
  double noise_floor = 0.0005;    // m; of an increment, from the encoder's resolution
  double lateral_noise = 0.003;   // m/sqrt(m); side slip
  double vertical_noise = 0.003;  // m/sqrt(m)
  double robust_threshold = 1.5;  // standard deviations at which an increment loses weight; 0: none
  double slip_window = 0.3;       // s; over which wheel and IMU are compared
  double slip_threshold = 5.0;    // standard deviations between them that are slip; 0: not watched
  double slip_share = 0.3;        // of the way on which the wheel slips gradually; 0: it never does
  double slip_size = 0.5;         // of ln(true / reported distance) where it does
  double slip_lasts = 20.0;       // s
  double max_speed = 5.0;         // m/s; faster increments are dropped
  double time_offset = 0.0;       // s; added to every stamp
};

struct StandstillConfig {
  bool enabled = true;
  double window = 0.4;            // s; over which IMU and wheel must be still
  double imu_ratio = 1.6;         // IMU variance over its noise at which the robot no longer stands
  double velocity_sigma = 0.002;  // m/s
  double position_sigma = 1e-4;   // m, between two states
  double rotation_sigma = 1e-5;   // rad, between two states
};

struct InitializerConfig {
  double duration = 2.0;             // s of standstill needed to start
  bool wait_for_standstill = false;  // never start on the move
  double max_gyro_std = 0.02;        // rad/s; noisier than this: not standing
  double max_accel_std = 0.2;        // m/s^2
  double max_gyro_mean = 0.05;       // rad/s; faster than this: turning, or a broken gyro
  double position_sigma = 1e-3;      // m; the origin's prior
  double yaw_sigma = 1e-3;           // rad; the origin's prior
  double gravity = 9.80665;          // m/s^2
};

struct SmootherConfig {
  double state_rate = 5.0;  // states per second
  double lag = 5.0;         // s
  SolverKind solver = SolverKind::kCeres;
  int max_iterations = 4;  // per update
  double latency = 0.05;   // s of data time from submission to effect
};

// Details retention, on each trace in this order.
struct GprFilterConfig {
  double dewow_window = 8e-9;   // s of the running mean that is taken out; 0: none
  double time_zero_max = 1e-9;  // s by which a trace may start early or late; 0: not tracked
  Background background = Background::kRunning;
  int background_memory = 400;  // traces
  WaveletKind wavelet = WaveletKind::kSym4;
  int wavelet_levels = 4;          // the approximation of the last one is zeroed
  double wavelet_threshold = 1.0;  // of noise sigma sqrt(2 ln n)
  double band_low = 1.5e8;         // Hz
  double band_high = 9.0e8;        // Hz
  double band_length = 1.0e-8;     // s of the filter that is run both ways; 0: no band-pass
  double gain_rate = 0.0;          // 1/sample
  double gain_power = 0.0;         // of the sample number
  int gain_flat_after = 80;        // samples
};

// Reflections in a filtered trace, which the subsurface feature matrix is made of.
struct PeaksConfig {
  bool fit = true;             // damped sinusoid per pulse; false: envelope maxima, much cheaper
  double min_snr = 3.5;        // envelope over the trace's noise from which a maximum is a pulse
  double min_relative = 0.05;  // envelope over the trace's greatest, likewise
  int max_joint = 1;           // overlapping pulses fitted together at most
  double max_residual = 0.3;   // misfit energy over signal energy of a fit that is kept
};

// Displacement from one B-scan window to the next (front ends sfm, bscan, dec and trace_count).
struct SequentialConfig {
  int window_traces = 100;   // L, traces in a window
  int rows = 50;             // D_S, of the feature matrix
  int columns = 50;          // L_S, of the feature matrix; shifts are in these columns
  double max_depth = 0.0;    // m, depth of the last row; 0: what the trace reaches
  double step = 0.5;         // s, Delta t between windows compared; whole ticks
  double k = 0.04;           // m per column: u = K |l*|
  double sigma = 0.05;       // m, error of K times the shift over one step
  double min_overlap = 0.3;  // w_min / L_S
  DistanceForm distance = DistanceForm::kCosine;
  double scale_duration = 20.0;  // s from the start that fix the amplitude scale of the levels
  double scale_quantile = 0.99;  // of the peak amplitudes then: pixel value 255
  bool publish_sfm = false;      // each window's feature matrix beside the displacement
};

// The dominant energy curve (front end dec).
struct DecConfig {
  double energy_window = 2.0e-9;  // s of a trace over which energy is averaged
  double first_time = 4.0e-9;     // s after time zero; earlier is the direct wave
  double jump_penalty = 0.01;     // score lost per squared sample of change from trace to trace
  int smoothing = 7;              // traces of the moving average over the curve
};

// Distance from the decay of trace similarity (front end motion).
struct CoherenceConfig {
  CoherenceUse use = CoherenceUse::kContradicted;  // when it enters the estimate
  double span = 1.0;                               // s of one distance
  double scale_distance = 5.0;  // m driven over which the ground's scale is learned
  double min_sigma = 0.05;      // least relative standard deviation
};

struct GprConfig {
  bool enabled = true;
  FrontEndKind front_end = FrontEndKind::kMotion;
  double tick = 0.1;                // s of data time between answers
  double latency_budget = 0.05;     // s of data time from tick to effect
  double wave_speed = 1.0e8;        // m/s in the ground
  double max_gap = 1.0;             // s; traces further apart: the front end starts afresh
  double time_offset = 0.0;         // s; added to every stamp
  double stationary_window = 0.6;   // s of traces compared
  Fusion fusion = Fusion::kSigned;  // how a displacement enters; the norm is the paper's
  double robust_threshold = 2.5;    // standard deviations at which it loses weight; 0: none
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  // m; antenna centre in body
  GprFilterConfig filter;
  PeaksConfig peaks;
  SequentialConfig sequential;
  DecConfig dec;
  CoherenceConfig coherence;
};

// Ground seen before, and the track in `map` that it ties together.
struct GraphConfig {
  bool enabled = true;
  double latency = 0.5;         // s of data time from a query to its effect on `map`
  double settle = 4.0;          // s after which a state is taken into the map
  double node_spacing = 0.5;    // m
  double query_spacing = 0.25;  // m driven between two questions to the memory
  double patch_length = 1.84;   // m of ground compared
  double gate_sigmas = 3.0;     // of the pose uncertainty within which ground is looked for
  double gate_min = 0.6;        // m; at least
  double gate_max = 5.0;        // m; at most
  double lateral_gate = 0.4;    // m; tracks further apart see other ground
  double certainty = 0.999;     // of a place, from which it is taken for a revisit
  double sigma_factor = 1.7;    // errors of a revisit over those its match foretells
  double lateral_sigma = 0.15;  // m; the antenna's footprint
  double memory_length = 10e3;  // m of ground that are kept
  double locate_every = 2.0;    // m driven between two searches of ground from before a reset
  double locate_length = 10.0;  // m of the newest ground that such a search compares
};

// What one run leaves to the next.
struct StateConfig {
  std::string directory;         // where it is kept; empty: nothing is
  MapUse map = MapUse::kExtend;  // whether new ground is written
  double save_period = 1.0;     // s of data time, of pose and wheel scale; of ground 300 times that
  double resume_within = 10.0;  // s; a saved pose not older than that is gone on from
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
